// What is read from a recording in the broker's place: tail, and --from of those who look on.
#include <gmock/gmock.h>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

std::string Header(const std::string& serial, int id) {
  return R"("headerId":)" + std::to_string(id) +
         R"(,"timestamp":"2026-03-04T05:06:07.000Z","version":"2.1.0","manufacturer":"KIT","serialNumber":")" +
         serial + "\"";
}

std::string State(const std::string& serial, int id, const std::string& more) {
  return "{" + Header(serial, id) +
         R"(,"orderId":"o1","orderUpdateId":0,"lastNodeId":"n4","lastNodeSequenceId":4,)"
         R"("nodeStates":[{"nodeId":"n5","sequenceId":6,"released":true}],)"
         R"("edgeStates":[{"edgeId":"e5","sequenceId":5,"released":true}],)"
         R"("actionStates":[],"operatingMode":"AUTOMATIC","errors":[],)"
         R"("safetyState":{"eStop":"NONE","fieldViolation":false},)" +
         more + "}";
}

std::string Battery(int charge) {
  return R"("batteryState":{"batteryCharge":)" + std::to_string(charge) + R"(,"charging":false})";
}

// A line as mosquitto_sub -F %j writes it.
std::string Line(const std::string& time, const std::string& topic, const std::string& payload,
                 bool retain = false) {
  std::string escaped;
  for (const char c : payload) escaped += c == '"' ? "\\\"" : std::string(1, c);
  return R"({"tst":"2026-03-04T)" + time + R"(.000000Z+0000","topic":"uagv/v2/)" + topic +
         R"(","qos":0,"retain":)" + (retain ? "1" : "0") + R"(,"payload":")" + escaped + "\"}\n";
}

class Recordings : public ::testing::Test {
 protected:
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  [[nodiscard]] Finished From(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--from", file_});
    return Fleetpub(std::move(arguments));
  }
  static std::string Shift() {
    const std::string online = "{" + Header("0001", 1) + R"(,"connectionState":"ONLINE"})";
    const std::string offline = "{" + Header("0002", 2) + R"(,"connectionState":"OFFLINE"})";
    return Line("05:06:07", "KIT/0001/connection", online, true) +
           Line("05:06:08", "KIT/0001/state",
                State("0001", 1, R"("driving":true,)" + Battery(62))) +
           Line("05:06:09", "KIT/0002/connection", offline) +
           Line("05:06:10", "KIT/0001/state",
                State("0001", 2, R"("driving":true,)" + Battery(62))) +
           Line(
               "05:06:11", "KIT/0001/instantActions",
               "{" + Header("0001", 1) +
                   R"(,"actions":[{"actionType":"startPause","actionId":"a1","blockingType":"NONE"}]})") +
           Line("05:06:17", "KIT/0001/state",
                State("0001", 3, R"("driving":false,"paused":true,)" + Battery(61)));
  }

  Operator operator_;
  std::string file_ = operator_.home().Write("shift.jsonl", Shift()).string();
};

// More than is read at once: nothing of it is lost on the way to where the commands look.
TEST_F(Recordings, SayTheSameOnStandardInput) {
  std::string shift = Shift();
  for (int i = 4; i < 900; ++i) {
    shift += Line("05:07:08", "KIT/0003/state", State("0003", i, Battery(i % 100)));
  }
  ASSERT_GT(shift.size(), 300'000U);
  file_ = operator_.home().Write("shift.jsonl", shift).string();
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"tail"},
                                                    {"fleet"},
                                                    {"watch"},
                                                    {"requests"},
                                                    {"show", "KIT/0001"},
                                                    {"await", "KIT/0001", "driving=true"},
                                                    {"validate"},
                                                    {"doctor"}}) {
    std::vector<std::string> words = arguments;
    words.insert(words.end(), {"-o", "json"});
    Finished expected = From(words);
    for (auto at = expected.output.find(file_); at != std::string::npos;
         at = expected.output.find(file_)) {
      expected.output.replace(at, file_.size(), "-");
    }
    for (const char* way : {"cat", "gzip", "zstd -q"}) {
      Command command = operator_.Prepare(words);
      command.arguments = {
          "bash", "-c", std::string(way) + " < \"$0\" | " + Binary() + " \"$@\" --from -", file_};
      command.arguments.insert(command.arguments.end(), words.begin(), words.end());
      const Finished run = ::fleetpub::testing::Run(std::move(command));
      EXPECT_EQ(run.exit_code, expected.exit_code) << words.front() << " " << run.errors;
      EXPECT_EQ(run.output, expected.output) << words.front() << " by " << way;
    }
  }
}

TEST_F(Recordings, AreNotReadTwiceOnStandardInput) {
  Command command = operator_.Prepare({"await", "KIT/*", "driving=true", "--from", "-"});
  command.input = Shift();
  const Finished run = ::fleetpub::testing::Run(std::move(command));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("standard input once only"));
}

TEST_F(Recordings, AreTailedInAPersonsWords) {
  Command command = operator_.Prepare({"tail", "--from", file_});
  command.environment.emplace_back("TZ", "UTC");
  const Finished run = ::fleetpub::testing::Run(std::move(command));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(
      Lines(run.output),
      ElementsAre("2026-03-04 05:06:07  KIT/0001 connection  ONLINE  (retained)",
                  "2026-03-04 05:06:08  KIT/0001 state  n4 → n5  order o1  driving  battery 62%",
                  "2026-03-04 05:06:09  KIT/0002 connection  OFFLINE",
                  "2026-03-04 05:06:10  KIT/0001 state  n4 → n5  order o1  driving  battery 62%",
                  "2026-03-04 05:06:11  KIT/0001 instantActions  startPause a1",
                  "2026-03-04 05:06:17  KIT/0001 state  n4 → n5  order o1  paused  battery 61%",
                  HasSubstr("as of 2026-03-04 05:06:17")));
}

TEST_F(Recordings, AreTailedForChangesAlone) {
  const Finished run = From({"tail", "KIT/0001", "--topic", "state", "--changes", "-o", "json"});
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(2)) << run.errors;
  EXPECT_EQ(Json(lines[0])["says"].Size(), 4U);
  const auto last = Json(lines[1]);
  EXPECT_STREQ(last["says"][0].GetString(), "paused");
  EXPECT_STREQ(last["says"][1].GetString(), "battery 61%");
  EXPECT_STREQ(last["time"].GetString(), "2026-03-04T05:06:17.000Z");
  EXPECT_EQ(last["message"]["headerId"].GetInt(), 3);
}

TEST_F(Recordings, ShowHowTheFleetStoodAtTheirEnd) {
  const Finished fleet = From({"fleet", "-o", "json"});
  const auto robots = Lines(fleet.output);
  ASSERT_THAT(robots, SizeIs(2)) << fleet.errors;
  EXPECT_TRUE(Json(robots[0])["paused"].GetBool());
  EXPECT_STREQ(Json(robots[1])["connectionState"].GetString(), "OFFLINE");
  const Finished text = From({"fleet", "KIT/0001"});
  EXPECT_THAT(text.output, AllOf(HasSubstr("61%"), HasSubstr("shift.jsonl, as of 2026-")));
  EXPECT_THAT(From({"fleet", "--where", "battery<62"}).output, HasSubstr("KIT/0001"));
}

TEST_F(Recordings, ShowOneRobotWithItsLastState) {
  const Finished show = From({"show", "KIT/0001", "-o", "json"});
  EXPECT_EQ(show.exit_code, 0) << show.errors;
  EXPECT_EQ(Json(show.output)["state"]["headerId"].GetInt(), 3);
  EXPECT_THAT(From({"show", "KIT/0001"}).output, HasSubstr("as of 2026-03-04"));
  const Finished unknown = From({"show", "KIT/0003"});
  EXPECT_EQ(unknown.exit_code, 7);
  EXPECT_THAT(unknown.errors, HasSubstr("shift.jsonl"));
}

TEST_F(Recordings, AreWatchedWithTheTimeOfEachChange) {
  const Finished run = From({"watch", "KIT/0001", "-o", "json"});
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, Not(IsEmpty())) << run.errors;
  EXPECT_STREQ(Json(lines.back())["time"].GetString(), "2026-03-04T05:06:17.000Z");
  EXPECT_THAT(lines, SizeIs(3));  // ONLINE, driving, paused
}

TEST_F(Recordings, AreAwaitedByTheirOwnTime) {
  const Finished found = From({"await", "KIT/0001", "paused=true"});
  EXPECT_EQ(found.exit_code, 0) << found.errors;
  EXPECT_THAT(found.output, HasSubstr("after 10 s"));
  EXPECT_EQ(From({"await", "KIT/*", "connection", "connectionState=OFFLINE"}).exit_code, 6);
  const Finished vain = From({"await", "KIT/0001", "battery<10"});
  EXPECT_EQ(vain.exit_code, 6);
  EXPECT_THAT(vain.errors, HasSubstr("recording"));
  EXPECT_EQ(From({"await", "KIT/0001", "factsheet", "version=2"}).exit_code, 6);
}

TEST_F(Recordings, AreValidatedWhole) {
  const Finished run = From({"validate", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  const auto summary = Json(Lines(run.output).back());
  EXPECT_EQ(summary["messages"].GetInt(), 6);
  EXPECT_EQ(summary["topics"]["instantActions"]["valid"].GetInt(), 1);
  EXPECT_EQ(summary["withoutConnection"].GetInt(), 0);
  EXPECT_EQ(From({"validate", "--live", "KIT/0002"}).exit_code, 0);
  operator_.home().Write("shift.jsonl",
                         Shift() + Line("05:06:18", "KIT/0001/state", "{}") +
                             Line("05:06:19", "KIT/0003/state", State("0003", 1, Battery(1))));
  const Finished wrong = From({"validate", "-o", "json"});
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_EQ(Json(Lines(wrong.output).back())["withoutConnection"].GetInt(), 1);
}

TEST_F(Recordings, TellWhatRobotsAskedFor) {
  std::string state = State("0001", 9, Battery(60));
  state.insert(
      state.size() - 1,
      R"(,"zoneRequests":[{"requestId":"r1","requestType":"ACCESS","zoneId":"z","zoneSetId":"s","requestStatus":"REQUESTED"}])");
  operator_.home().Write("shift.jsonl", Shift() + Line("05:06:18", "KIT/0001/state", state));
  EXPECT_THAT(From({"requests"}).output, HasSubstr("r1"));
}

TEST_F(Recordings, NeedNoBrokerAndNoLogin) {
  operator_.UseBroker("mqtt://127.0.0.1:1");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"fleet"},
                                                    {"show", "KIT/0001"},
                                                    {"watch"},
                                                    {"requests"},
                                                    {"tail"},
                                                    {"await", "KIT/0001", "paused=true"},
                                                    {"validate", "KIT/0002"}}) {
    EXPECT_EQ(From(arguments).exit_code, 0) << arguments.front();
  }
}

TEST_F(Recordings, AreRefusedWhereTheyMakeNoSense) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"fleet", "--ask"},
                                                    {"watch", "--for", "1s"},
                                                    {"tail", "--for", "1s"},
                                                    {"await", "KIT/0001", "a=1", "-W", "1s"},
                                                    {"validate", "--for", "1s"}}) {
    EXPECT_EQ(From(arguments).exit_code, 2) << arguments.front();
  }
  file_ = operator_.home().Write("text", "Dear diary\n").string();
  const std::string none = (operator_.home() / "none.jsonl").string();
  for (const char* command : {"fleet", "watch", "tail", "validate", "requests"}) {
    EXPECT_EQ(From({command}).exit_code, 3) << command;
    EXPECT_EQ(Fleetpub({command, "--from", none}).exit_code, 8) << command;
  }
}

TEST_F(Recordings, TellWhatIsWrongWithThem) {
  operator_.home().Write("shift.jsonl", Shift() + "{\"topic\n" + Shift());
  const Finished run = From({"fleet"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("1 line "), HasSubstr("shift.jsonl:7")));
}

}  // namespace
}  // namespace fleetpub::testing
