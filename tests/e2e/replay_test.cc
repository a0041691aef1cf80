// `fleetpub replay`: what was said, again, and what is never said by itself.
#include <gmock/gmock.h>

#include <cmath>
#include <thread>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class Replay : public EndToEnd {
 protected:
  static std::string Line(double t, const std::string& topic, const std::string& payload,
                          bool retain = false) {
    std::string escaped;
    for (const char c : payload) escaped += c == '"' ? "\\\"" : std::string(1, c);
    return fmt::format(
        R"({{"t":{},"at":"2026-03-04T05:06:07.000Z","topic":"uagv/v2/KIT/{}","qos":0,"retain":{},"payload":"{}"}})"
        "\n",
        t, topic, retain, escaped);
  }
  static std::string Said(int id) {
    return fmt::format(
        R"({{"headerId":{},"timestamp":"2026-03-04T05:06:07.000Z","version":"2.1.0","manufacturer":"KIT","serialNumber":"0001","x":1.50}})",
        id);
  }
  static std::string AtQos1(std::string line) {
    return line.replace(line.find(R"("qos":0)"), 7, R"("qos":1)");
  }
  void Write(const std::string& text) { operator_.home().Write("shift.jsonl", text); }
  [[nodiscard]] Finished Play(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"replay", (operator_.home() / "shift.jsonl").string()});
    return Fleetpub(std::move(arguments));
  }
};

TEST_F(Replay, KeepsOrderBytesAndGaps) {
  std::string text;
  const std::vector<double> times = {10, 10.02, 10.02, 10.07, 13};
  for (std::size_t i = 0; i < times.size(); ++i) {
    text += Line(times[i], "0001/state", Said(static_cast<int>(7 + i)));
  }
  Write(text);
  Process listener({{"mosquitto_sub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-t",
                     "#", "-F", "%U %t %p"}});
  ASSERT_TRUE(broker_.AwaitSubscription("# (QoS 0)"));
  const Finished run = Play({"-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  ASSERT_TRUE(listener.AwaitOutput("\"headerId\":11"));
  const auto lines = Lines(listener.Output());
  ASSERT_THAT(lines, SizeIs(5));
  const double start = std::stod(lines[0]);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_THAT(lines[i], HasSubstr(" uagv/v2/KIT/0001/state " + Said(static_cast<int>(7 + i))));
    EXPECT_NEAR(std::stod(lines[i]) - start, times[i] - times[0], 2 * kSlowness);
  }
}

TEST_F(Replay, GivesRobotsOtherNamesAndCountsAnew) {
  Write(Line(0, "0001/state", Said(7)) + Line(1, "0002/state", Said(7)) +
        Line(4, "0001/state", Said(9)));
  const Subscriber listener(broker_);
  const Finished run =
      Play({"--map", "KIT/0001=TEST/9", "--restamp", "--speed", "100", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(Json(run.output)["othersLeftOut"].GetInt(), 1);
  const auto heard = listener.Await(2);
  ASSERT_THAT(heard, SizeIs(2));
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_EQ(heard[i].topic, "uagv/v2/TEST/9/state");
    const auto json = Json(heard[i].payload);
    EXPECT_STREQ(json["manufacturer"].GetString(), "TEST");
    EXPECT_STREQ(json["serialNumber"].GetString(), "9");
    EXPECT_EQ(json["headerId"].GetUint(), i);
    EXPECT_STRNE(json["timestamp"].GetString(), "2026-03-04T05:06:07.000Z");
    EXPECT_EQ(json["x"].GetDouble(), 1.5);
  }
}

TEST_F(Replay, GivesAllRobotsOfAMakerAnother) {
  Write(Line(0, "0001/state", Said(1)) + Line(0, "0002/state", Said(1)));
  const Subscriber listener(broker_);
  EXPECT_EQ(Play({"--map", "KIT/*=TEST/*"}).exit_code, 0);
  const auto heard = listener.Await(2);
  ASSERT_THAT(heard, SizeIs(2));
  EXPECT_EQ(heard[0].topic, "uagv/v2/TEST/0001/state");
  EXPECT_EQ(heard[1].topic, "uagv/v2/TEST/0002/state");
}

TEST_F(Replay, CommandsNobodyWithoutConsent) {
  Write(Line(0, "0001/order", Said(1)) + Line(0, "0001/instantActions", Said(2)) +
        Line(0, "0001/zoneSet", Said(3)) + Line(0, "0001/responses", Said(4)) +
        Line(0, "0001/state", Said(5)));
  const Subscriber listener(broker_);
  const Finished plain = Play({"-o", "json"});
  EXPECT_EQ(plain.exit_code, 0) << plain.errors;
  EXPECT_EQ(Json(plain.output)["commandsLeftOut"].GetInt(), 4);
  EXPECT_EQ(Json(plain.output)["messages"].GetInt(), 1);
  const Finished asked = Play({"--commands"});
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_THAT(asked.errors, HasSubstr("--yes"));
  EXPECT_EQ(Play({"--yes"}).exit_code, 2);
  const Finished agreed = Play({"--commands", "--yes", "-o", "json"});
  EXPECT_EQ(agreed.exit_code, 0) << agreed.errors;
  EXPECT_THAT(listener.Await(6), SizeIs(6));
}

TEST_F(Replay, PutsBackWhatWasRetained) {
  Say("uagv/v2/TEST/0001/factsheet", "{\"old\":1}", true);
  const std::string online = R"({"headerId":1,"connectionState":"ONLINE"})";
  Write(Line(0, "0001/connection", online) + Line(0, "0001/factsheet", "{}") +
        Line(0, "0001/state", Said(1)));
  {
    const Subscriber live(broker_);
    EXPECT_EQ(Play({"--map", "KIT/0001=TEST/0001"}).exit_code, 0);
    EXPECT_THAT(live.Await(6), SizeIs(6));
  }
  const Subscriber later(broker_);
  const auto left = later.Await(1);
  ASSERT_THAT(left, SizeIs(1));
  EXPECT_EQ(left[0].payload, "{\"old\":1}");
  EXPECT_EQ(Play({"--map", "KIT/0001=TEST/0002", "--keep"}).exit_code, 0);
  const Subscriber kept(broker_, "uagv/v2/TEST/0002/#");
  const auto retained = kept.Await(2);
  ASSERT_THAT(retained, SizeIs(2));
  EXPECT_TRUE(retained[0].retained && retained[1].retained);
}

TEST_F(Replay, TakesNobodysPlace) {
  Say("uagv/v2/KIT/0001/connection", R"({"connectionState":"ONLINE"})", true);
  Write(Line(0, "0001/connection", R"({"connectionState":"OFFLINE"})") +
        Line(0, "0001/state", Said(1)));
  const Finished run = Play({});
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("nothing was sent"), HasSubstr("--map")));
  EXPECT_EQ(Play({"--force"}).exit_code, 0);
}

TEST_F(Replay, StaysAtAStatedInterface) {
  Say("uagv/v2/KIT/0001/connection", R"({"connectionState":"ONLINE"})", true);
  Write(Line(0, "0001/state", Said(1)));
  EXPECT_EQ(Play({"--interface", "uagv"}).exit_code, 7);
  const Subscriber states(broker_, "+/+/TEST/+/state");
  EXPECT_EQ(Play({"--interface", "uagv", "--map", "KIT/*=TEST/*"}).exit_code, 0);
  const auto heard = states.Await(1);
  ASSERT_THAT(heard, SizeIs(1));
  EXPECT_EQ(heard[0].topic, "uagv/v2/TEST/0001/state");
}

TEST_F(Replay, TakesNobodysPlaceThatItOnlySendsStatesOf) {
  Say("uagv/v2/KIT/0001/connection", R"({"connectionState":"ONLINE"})", true);
  Write(Line(0, "0001/state", Said(1)));
  EXPECT_EQ(Play({}).exit_code, 7);
}

TEST_F(Replay, EndsAtOnceAndTidiesUp) {
  Write(Line(0, "0001/connection", R"({"connectionState":"ONLINE"})") +
        Line(60, "0001/state", Said(1)));
  Process player(operator_.Prepare({"replay", (operator_.home() / "shift.jsonl").string()}));
  const Subscriber listener(broker_);
  ASSERT_THAT(listener.Await(1), SizeIs(1));
  player.Signal(SIGINT);
  EXPECT_EQ(player.Wait(), 130) << player.Errors();
  ASSERT_THAT(listener.Await(2), SizeIs(2));
  EXPECT_THAT(listener.Await(2)[1].payload, IsEmpty());
}

// At QoS 1: the robot's ONLINE, then a state every 100 ms.
TEST_F(Replay, GoesOnWhenTheBrokerComesBack) {
  constexpr int kStates = 20;
  std::string text = Line(0, "0001/connection", R"({"headerId":1,"connectionState":"ONLINE"})");
  for (int id = 0; id < kStates; ++id) {
    text += AtQos1(Line(0.1 * (id + 1), "0001/state", Said(id)));
  }
  Write(text);
  auto listener = std::make_unique<Subscriber>(broker_, "#", 1);
  Process player(operator_.Prepare(
      {"replay", (operator_.home() / "shift.jsonl").string(), "--keep", "-o", "json"}));
  ASSERT_THAT(listener->Await(3), SizeIs(3));
  broker_.Kill();
  ASSERT_TRUE(player.AwaitErrors("connecting again")) << player.Errors();
  const auto before = listener->SoFar();
  listener.reset();  // it would connect again
  player.Signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(2));  // longer than it is late otherwise
  broker_.Restart();
  const Subscriber after(broker_, "#", 1);
  player.Signal(SIGCONT);
  EXPECT_EQ(player.Wait(), 0) << player.Errors();
  EXPECT_THAT(player.Errors(), HasSubstr("connected again"));
  const auto told = Json(Lines(player.Output()).back());
  EXPECT_EQ(told["messages"].GetInt(), kStates + 1);
  EXPECT_EQ(told["losses"].GetInt(), 1);
  EXPECT_GT(told["lostMs"].GetDouble(), 400);
  EXPECT_LT(told["latestMs"].GetDouble(), told["lostMs"].GetDouble());

  ASSERT_TRUE(after.AwaitPayload(Said(kStates - 1)));
  std::map<std::string, int> heard;
  for (const auto& some : {before, after.SoFar()}) {
    for (const auto& one : some) ++heard[one.payload];
  }
  int twice = 0;
  for (const auto& [payload, times] : heard) twice += times - 1;
  EXPECT_THAT(heard, SizeIs(kStates + 1)) << "nothing is missing";
  EXPECT_LE(twice, told["sentAgain"].GetInt()) << "what was sent once is not heard twice";
  const Subscriber later(broker_);
  ASSERT_THAT(later.Await(1), SizeIs(1));
  EXPECT_EQ(later.Await(1)[0].topic, "uagv/v2/KIT/0001/connection") << "the broker had lost it";
}

TEST_F(Replay, SaysWhenTheBrokerRefusesWhatItSays) {
  const Mosquitto broker({"allow_anonymous true", "acl_file {}/acl"}, {{"acl", "topic read #\n"}});
  operator_.UseBroker(broker.Url());
  Write(AtQos1(Line(0, "0001/connection", "{}")) + AtQos1(Line(0, "0001/state", Said(1))));
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"-V", "5"}, {"-V", "5", "--keep"}}) {
    const Finished run = Play(arguments);
    EXPECT_EQ(run.exit_code, 4) << run.errors;
    EXPECT_THAT(run.errors, AllOf(HasSubstr("refused 2 of 2 messages"), HasSubstr("0x87")));
    EXPECT_EQ(run.output, "");
  }
}

TEST_F(Replay, CanBeEndedWhileThereIsNoBroker) {
  const std::string file = (operator_.home() / "shift.jsonl").string();
  for (const auto& [topic, exit_code] : {std::pair("state", 130), {"connection", 4}}) {
    Write(Line(0, fmt::format("0001/{}", topic), Said(1)) + Line(60, "0001/state", Said(2)));
    const Subscriber listener(broker_);
    Process player(operator_.Prepare({"replay", file}));
    ASSERT_THAT(listener.Await(1), SizeIs(1));
    broker_.Kill();
    ASSERT_TRUE(player.AwaitErrors("connecting again")) << player.Errors();
    player.Signal(SIGINT);
    EXPECT_EQ(player.Wait(), exit_code) << "what is retained cannot be put back";
    broker_.Restart();
  }
}

TEST_F(Replay, RefusesWhatItCannotPlay) {
  Write(Line(0, "0001/state", Said(1)));
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--map", "KIT/0001"},
                                                    {"--map", "KIT/0001=TEST"},
                                                    {"--map", "KIT/0001=TEST/+"},
                                                    {"--map", "KIT/0001=/1"},
                                                    {"--speed", "0"},
                                                    {"--speed", "fast"}}) {
    EXPECT_EQ(Play(arguments).exit_code, 2) << arguments.back();
  }
  EXPECT_EQ(Play({"--map", "ACME/1=TEST/1"}).exit_code, 7);
  Write(Line(0, "0001/state", Said(1)) + Line(0, "0002/state", Said(2)));
  const Finished merged = Play({"--map", "KIT/*=TEST/7"});
  EXPECT_EQ(merged.exit_code, 2);
  EXPECT_THAT(merged.errors, HasSubstr("KIT/0001 and KIT/0002 would both be TEST/7"));
  EXPECT_EQ(Fleetpub({"replay"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"replay", "-"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"replay", "none.jsonl"}).exit_code, 8);
}

}  // namespace
}  // namespace fleetpub::testing
