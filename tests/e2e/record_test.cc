// `fleetpub record` beside a client that we did not write, and what is left when it is ended.
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/file.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAreArray;

class Record : public EndToEnd {
 protected:
  // Listens when this returns.
  std::unique_ptr<Process> Start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "record");
    auto recorder = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(recorder->AwaitErrors("recording mqtt")) << recorder->Errors();
    return recorder;
  }
  // Of `lines`, each a message. At QoS 0 mosquitto_pub 2.0.11 may hang at the end of its input.
  void Flood(const std::string& topic, const std::string& lines) const {
    Command command{{"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-t",
                     topic, "-q", "1", "-l"}};
    command.input = lines;
    EXPECT_EQ(::fleetpub::testing::Run(std::move(command)).exit_code, 0);
  }
  [[nodiscard]] std::string File(const std::string& name) const {
    return (operator_.home() / name).string();
  }
  // The lines of a file until it holds so many messages.
  std::vector<std::string> AwaitMessages(const std::string& name, std::size_t count) const {
    for (int i = 0; i < 1'000; ++i) {
      const auto lines = Lines(*base::ReadFile(File(name)));
      if (Topics(lines).size() >= count) return lines;
      std::this_thread::sleep_for(std::chrono::microseconds(10'000));
    }
    ADD_FAILURE() << "fewer than " << count << " messages";
    return {};
  }
  // `TOPIC PAYLOAD` of those that are messages.
  static std::vector<std::string> Topics(const std::vector<std::string>& lines) {
    std::vector<std::string> messages;
    for (const std::string& line : lines) {
      const auto json = Json(line);
      if (!json.HasMember("topic")) continue;
      const bool has_payload = json.HasMember("payload") && json["payload"].IsString();
      messages.push_back(std::string(json["topic"].GetString()) + " " +
                         (has_payload ? json["payload"].GetString() : ""));
    }
    return messages;
  }
};

TEST_F(Record, HearsWhatMosquittoSubHears) {
  Say("vda5050/v3/KIT/0001/connection", "{\"x\": 1.0}", true);
  Process other({{"mosquitto_sub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-t",
                  "#", "-F", "%j"}});
  ASSERT_TRUE(other.AwaitOutput("connection"));
  const auto recorder = Start({"--filter", "#", "-f", File("a.jsonl")});
  std::string lines;
  for (int i = 0; i < 2'000; ++i) lines += "{\"i\": " + std::to_string(i) + ", \"ä\": \"\\n\"}\n";
  Flood("uagv/v2/KIT/0002/state", lines);
  Flood("soar/a/b", "no JSON at all\t\"\\\n");
  const auto recorded = AwaitMessages("a.jsonl", 2'002);
  ASSERT_TRUE(other.AwaitOutput("soar/a/b"));
  EXPECT_THAT(Topics(recorded), UnorderedElementsAreArray(Topics(Lines(other.Output()))));
  recorder->Signal();
  EXPECT_EQ(recorder->Wait(), 0) << recorder->Errors();
}

TEST_F(Record, ListensToTheRobotsThatAreMeant) {
  const auto recorder = Start({"KIT/00*", "*/0001", "KIT/0001", "--except", "KIT/0009", "--topic",
                               "state", "-f", File("a.jsonl")});
  for (const char* topic :
       {"uagv/v2/KIT/0001/connection", "uagv/v2/KIT/1/state", "uagv/v2/KIT/0009/state",
        "uagv/v2/ACME/0001/state", "other/v2/KIT/0001/state", "vda5050/v3/KIT/0002/state"}) {
    Say(topic, "{}", false);
  }
  const auto recorded = AwaitMessages("a.jsonl", 3);
  EXPECT_THAT(Topics(recorded),
              UnorderedElementsAreArray({"uagv/v2/ACME/0001/state {}", "other/v2/KIT/0001/state {}",
                                         "vda5050/v3/KIT/0002/state {}"}));
}

TEST_F(Record, ListensWhereTopicsTellNoManufacturer) {
  const auto recorder = Start(
      {"KIT/0001", "ACME/7", "--topic-template", "fleet/{serial}/{topic}", "-f", File("a.jsonl")});
  for (const char* topic : {"fleet/0002/state", "fleet/7/state", "fleet/0001/state"}) {
    Say(topic, "{}", false);
  }
  EXPECT_THAT(Topics(AwaitMessages("a.jsonl", 2)),
              UnorderedElementsAreArray({"fleet/7/state {}", "fleet/0001/state {}"}));
}

TEST_F(Record, EndsWithAFootAndASummary) {
  const auto recorder = Start({"-f", File("a.jsonl"), "-o", "json"});
  Say("uagv/v2/KIT/0001/state", "{}", false);
  AwaitMessages("a.jsonl", 1);
  recorder->Signal(SIGINT);
  EXPECT_EQ(recorder->Wait(), 0) << recorder->Errors();
  const auto summary = Json(recorder->Output());
  EXPECT_EQ(summary["messages"].GetInt(), 1);
  EXPECT_EQ(summary["overflow"].GetInt(), 0);
  const auto lines = Lines(*base::ReadFile(File("a.jsonl")));
  ASSERT_THAT(lines, SizeIs(4));
  const auto head = Json(lines.front());
  EXPECT_STREQ(head["format"].GetString(), "fleetpub-recording");
  EXPECT_EQ(std::string(head["broker"].GetString()), broker_.Url());
  EXPECT_THAT(lines[1], HasSubstr(R"("event":"connected")"));
  EXPECT_EQ(Json(lines.back())["count"].GetInt(), 1);
  const auto sum = ::fleetpub::testing::Run({{"sh", "-c", "head -n 3 a.jsonl | sha256sum"},
                                             {},
                                             std::string(),
                                             operator_.home().path().string()});
  EXPECT_THAT(sum.output, HasSubstr(Json(lines.back())["sha256"].GetString()));
}

TEST_F(Record, LeavesWholeLinesWhenItIsKilled) {
  const auto recorder = Start({"--filter", "#", "-f", File("a.jsonl")});
  std::string lines;
  for (int i = 0; i < 3'000; ++i) lines += std::string(1'000, 'x') + "\n";
  Flood("a/b", lines);
  AwaitMessages("a.jsonl", 100);
  recorder->Signal(SIGKILL);
  EXPECT_EQ(recorder->Wait(), 128 + SIGKILL);
  const std::string text = *base::ReadFile(File("a.jsonl"));
  EXPECT_THAT(text, EndsWith("\n"));
  EXPECT_GE(Topics(Lines(text)).size(), 100U);
  const Finished read = Fleetpub({"tail", "--filter", "#", "--from", File("a.jsonl")});
  EXPECT_EQ(read.exit_code, 0);
  EXPECT_THAT(read.errors, HasSubstr("has no end"));
}

TEST_F(Record, CompressesAsTheNameSays) {
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"a.jsonl.gz", {"gzip", "-dc"}}, {"a.jsonl.zst", {"zstd", "-dc"}}};
  for (const auto& [name, unpack] : cases) {
    const auto recorder = Start({"-f", File(name)});
    std::string lines;
    for (int i = 0; i < 500; ++i) lines += "{\"headerId\": " + std::to_string(i) + "}\n";
    Flood("uagv/v2/KIT/0001/state", lines);
    const std::vector<std::string> read = {"tail", "--from", File(name), "-o", "json"};
    for (int i = 0; i < 500 && Lines(Fleetpub(read).output).size() < 500; ++i)
      std::this_thread::sleep_for(std::chrono::microseconds(10'000));
    EXPECT_THAT(Lines(Fleetpub(read).output), SizeIs(500)) << name;  // flushed
    recorder->Signal();
    EXPECT_EQ(recorder->Wait(), 0);
    auto command = unpack;
    command.push_back(File(name));
    const Finished unpacked = ::fleetpub::testing::Run({command});
    EXPECT_EQ(unpacked.exit_code, 0) << unpacked.errors;
    EXPECT_THAT(Topics(Lines(unpacked.output)), SizeIs(500));
    EXPECT_LT(std::filesystem::file_size(File(name)), unpacked.output.size() / 5);
  }
}

TEST_F(Record, BeginsNewFilesAndReadsThemAsOne) {
  const auto recorder = Start({"-f", File("a.jsonl"), "--rotate", "1kB"});
  for (int i = 0; i < 3; ++i) {
    Say("uagv/v2/KIT/0001/state", "{\"s\": \"" + std::string(1'000, 'x') + "\"}", false);
    const auto next = File("a.000" + std::to_string(i + 2) + ".jsonl");
    for (int j = 0; j < 1'000 && !std::filesystem::exists(next); ++j)
      std::this_thread::sleep_for(std::chrono::microseconds(10'000));
  }
  recorder->Signal();
  EXPECT_EQ(recorder->Wait(), 0);
  EXPECT_THAT(recorder->Output(), HasSubstr("4 files"));
  const Finished read = Fleetpub({"tail", "--from", File("a.jsonl")});
  EXPECT_THAT(Lines(read.output), SizeIs(4));  // and what it is from
  EXPECT_THAT(read.errors, IsEmpty());
}

TEST_F(Record, NotesWhenTheConnectionWasLost) {
  const auto recorder = Start({"-f", File("a.jsonl"), "-o", "json"});
  broker_.Kill();
  ASSERT_TRUE(recorder->AwaitErrors("connecting again"));
  broker_.Restart();
  ASSERT_TRUE(recorder->AwaitErrors("connected again"));
  Say("uagv/v2/KIT/0001/state", "{}", false);
  const auto lines = AwaitMessages("a.jsonl", 1);
  std::vector<std::string> events;
  for (const std::string& line : lines) {
    const auto json = Json(line);
    if (json.HasMember("event")) events.emplace_back(json["event"].GetString());
    if (events.empty() || events.back() != "gap") continue;
    if (json.HasMember("seconds")) {
      EXPECT_GT(json["seconds"].GetDouble(), 0);
    }
  }
  EXPECT_THAT(events, ::testing::ElementsAre("connected", "lost", "gap", "resubscribed"));
  recorder->Signal();
  EXPECT_EQ(recorder->Wait(), 0);
  EXPECT_EQ(Json(recorder->Output())["gaps"].GetInt(), 1);
}

TEST_F(Record, KeepsWhatThePublisherSaidOfRetainingOnMqtt5) {
  const auto recorder = Start({"-f", File("a.jsonl"), "-V", "5", "-q", "2"});
  Say("uagv/v2/KIT/0001/connection", "{}", true);
  Say("uagv/v2/KIT/0001/state", "{}", false);
  const auto lines = AwaitMessages("a.jsonl", 2);
  EXPECT_TRUE(Json(lines[0])["retainAsPublished"].GetBool());
  for (const std::string& line : lines) {
    const auto json = Json(line);
    if (!json.HasMember("topic")) continue;
    EXPECT_EQ(json["retain"].GetBool(),
              std::string(json["topic"].GetString()).ends_with("connection"));
  }
}

TEST_F(Record, RefusesWhatItCannotDo) {
  operator_.home().Write("there.jsonl", "precious");
  const std::pair<std::vector<std::string>, int> cases[] = {
      {{"record"}, 2},
      {{"record", "-f", "-"}, 2},
      {{"conform", "KIT/0001", "--record", "-"}, 2},
      {{"record", "-f", File("there.jsonl")}, 8},
      {{"record", "-f", File("no/folder.jsonl")}, 8},
      {{"record", "-f", File("a"), "--rotate", "often"}, 2},
      {{"record", "-f", File("a"), "--rotate", "0s"}, 2},
      {{"record", "-f", File("a"), "--rotate", "0MB"}, 2},
      {{"record", "-f", File("a"), "--topic", "staet"}, 2},
      {{"record", "-f", File("a"), "--filter", "#", "KIT/0001"}, 2},
      {{"record", "-f", File("a"), "--filter", "a/#/b", "--for", "1s"}, 4},
      {{"record", "-f", File("a"), "-b", "mqtt://127.0.0.1:1"}, 4}};
  for (const auto& [arguments, code] : cases) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, code) << arguments.back() << run.errors;
    EXPECT_THAT(run.errors, Not(IsEmpty()));
  }
  EXPECT_EQ(*base::ReadFile(File("there.jsonl")), "precious");
  EXPECT_FALSE(std::filesystem::exists(File("a")));
  EXPECT_FALSE(std::filesystem::exists("-"));
}

}  // namespace
}  // namespace fleetpub::testing
