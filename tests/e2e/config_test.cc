// Configuration files: whose word holds, whom a name means, and that no secret comes out.
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;

class Configuration : public ::testing::Test {
 protected:
  // The user's own file.
  std::filesystem::path Write(const std::string& text) const {
    auto file = operator_.home().Write(".config/fleetpub/config.toml", text);
    chmod(file.c_str(), 0600);
    return file;
  }
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  /// To robots that need not be there.
  [[nodiscard]] Finished Send(std::vector<std::string> arguments) const {
    return operator_.Send(std::move(arguments));
  }
  [[nodiscard]] Finished FleetpubWith(std::string variable, std::string value,
                                      std::vector<std::string> arguments) const {
    Command command = operator_.Prepare(std::move(arguments));
    command.environment.emplace_back(std::move(variable), std::move(value));
    return fleetpub::testing::Run(std::move(command));
  }
  // Value and origin that config show prints.
  [[nodiscard]] static std::string Shown(const Finished& run, const std::string& key) {
    for (const std::string& line : Lines(run.output)) {
      const auto row = Json(line);
      if (row["key"].GetString() == key) {
        return std::string(row["value"].GetString()) + " | " + row["origin"].GetString();
      }
    }
    return "not shown";
  }

  Operator operator_;
};

TEST_F(Configuration, FlagThenEnvironmentThenProfileThenFileThenDefault) {
  const std::string file = Write(
                               "qos = 1\ntopic_template = \"t/{manufacturer}/{serial}/{topic}\"\n"
                               "client_id = \"file\"\nconnect_timeout = \"1s\"\n"
                               "[profile.north]\nclient_id = \"north\"\nconnect_timeout = \"2s\"\n")
                               .string();
  const Finished run =
      FleetpubWith("FLEETPUB_CONNECT_TIMEOUT", "3s",
                   {"config", "show", "-o", "json", "--profile", "north", "--keep-alive", "9"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(Shown(run, "profile"), "north | flag --profile");
  EXPECT_EQ(Shown(run, "keep_alive"), "9 | flag --keep-alive");
  EXPECT_EQ(Shown(run, "connect_timeout"), "3s | environment variable FLEETPUB_CONNECT_TIMEOUT");
  EXPECT_EQ(Shown(run, "client_id"), "north | profile north of " + file + ":6");
  EXPECT_EQ(Shown(run, "qos"), "1 | " + file + ":1");
  EXPECT_EQ(Shown(run, "mqtt_version"), "3.1.1 | default");
  EXPECT_EQ(Shown(run, "topic_template"), "t/{manufacturer}/{serial}/{topic} | " + file + ":2");
}

TEST_F(Configuration, ChoosesBrokerQosOutputAndVersion) {
  const Mosquitto broker;
  Write("broker = \"" + broker.Url() + "\"\nqos = 1\noutput = \"json\"\nvda = \"2.1\"\n");
  const Subscriber subscriber(broker);
  const Finished run = Fleetpub({"pause", "KIT/0001", "--no-check"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto report = Json(run.output);
  EXPECT_STREQ(report["status"].GetString(), "PUBLISHED");
  EXPECT_STREQ(report["topic"].GetString(), "uagv/v2/KIT/0001/instantActions");
  EXPECT_FALSE(report.HasMember("versionAssumed"));
  EXPECT_THAT(subscriber.Await(1), SizeIs(1));
  const Finished text = Send({"pause", "KIT/0001", "-o", "text", "--vda", "3", "-q", "0"});
  EXPECT_THAT(text.output, HasSubstr("SENT"));
  const Finished other = Fleetpub({"pause", "KIT/0001", "--host", "127.0.0.1", "-p", "1"});
  EXPECT_EQ(other.exit_code, 4) << "--host goes before the configured broker";
}

TEST_F(Configuration, NamesTheFileWithAFlagOrAVariableInsteadOfTheUsual) {
  Write("qos = 2\n");
  const std::string other = operator_.home().Write("other.toml", "qos = 1\n").string();
  EXPECT_EQ(Shown(Fleetpub({"config", "show", "-o", "json", "--config", other}), "qos"),
            "1 | " + other + ":1");
  EXPECT_EQ(Shown(FleetpubWith("FLEETPUB_CONFIG", other, {"config", "show", "-o", "json"}), "qos"),
            "1 | " + other + ":1");
  EXPECT_EQ(Shown(Fleetpub({"config", "show", "-o", "json", "--config=/dev/null"}), "qos"),
            "0 | default");
}

TEST_F(Configuration, RecordsTheProfileOfEachMessage) {
  const Mosquitto broker;
  Write("default_profile = \"north\"\n[profile.north]\nbroker = \"" + broker.Url() + "\"\n");
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_STREQ(Json(Fleetpub({"history", "-o", "json"}).output)["profile"].GetString(), "north");
  EXPECT_THAT(Fleetpub({"history", "show", "1"}).output, HasSubstr("profile    north"));
}

TEST_F(Configuration, HeaderIdsMayBeginWithTheTime) {
  Write("header_id_start = \"epoch\"\noutput = \"json\"\n");
  const auto report = Json(Fleetpub({"pause", "KIT/0001", "--dry-run"}).output);
  EXPECT_GT(report["headerId"].GetUint(), 1'700'000'000U);
  const Mosquitto broker;
  const std::vector<std::string> asked = {"pause",      "KIT/0001",    "--broker",
                                          broker.Url(), "--header-id", "5"};
  auto dry = asked;
  dry.emplace_back("--dry-run");
  EXPECT_EQ(Json(Fleetpub(dry).output)["headerId"].GetUint(), 5U)
      << "a topic without one takes any";
  EXPECT_EQ(Json(Send(asked).output)["headerId"].GetUint(), 5U);
  EXPECT_EQ(Fleetpub(dry).exit_code, 2) << "as sending would be";
}

TEST_F(Configuration, WhatIsWrongIsRefusedWithItsPlaceAndNothingIsSent) {
  const Mosquitto broker;
  const Subscriber subscriber(broker);
  struct Case {
    std::string text;
    std::vector<std::string> arguments;
    std::string sentence;
  };
  for (const auto& [text, arguments, sentence] : std::vector<Case>{
           {"\nbrokr = \"x\"\n", {}, "config.toml:2:1: brokr: there is no such key: did you mean"},
           {"qos = \"1\"\n", {}, "config.toml:1:1: qos: takes a whole number, not a text"},
           {"a = \n", {}, "config.toml:1:"},
           {"\xFF", {}, "not valid TOML"},
           {"insecure = true\n", {}, "allow_insecure = true beside it"},
           {"[profile.north]\n", {"--profile", "nroth"}, "did you mean north?"},
           {"", {"--profile", "north"}, "no file has a table [profile.NAME]"},
           {"", {"--config", "/nowhere.toml"}, "/nowhere.toml cannot be read: No such file"},
           {"", {"--config", "/"}, "/ cannot be read: it is a folder"},
           {"", {"@hall"}, "there is no group '@hall'"},
           {"[group]\nhall-1 = [\"KIT/2\"]\n", {"@hal-1"}, "did you mean @hall-1?"},
           {"[group]\nhall-1 = [\"KIT/2\"]\n", {"hall-1"}, "did you mean @hall-1?"},
           {"[robot.\"KIT/2\"]\nalias = \"agv2\"\n", {"agv1"}, "did you mean agv2?"},
       }) {
    Write("broker = \"" + broker.Url() + "\"\n");
    Write(text);
    std::vector<std::string> all = {"pause", "KIT/0001", "-b", broker.Url()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Finished run = Fleetpub(all);
    EXPECT_EQ(run.exit_code, 2) << text << run.errors;
    EXPECT_THAT(run.errors, HasSubstr(sentence));
    EXPECT_THAT(run.output, IsEmpty());
  }
  Write("");
  EXPECT_EQ(Send({"resume", "KIT/0001", "-b", broker.Url(), "-q", "1"}).exit_code, 0);
  EXPECT_THAT(subscriber.Await(1), SizeIs(1));
}

TEST_F(Configuration, AFileThatEverybodyCanWriteIsRefused) {
  const auto file = Write("qos = 1\n");
  chmod(file.c_str(), 0602);
  const Finished run = Fleetpub({"pause", "KIT/0001", "--dry-run"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("everybody can write it"));
}

TEST_F(Configuration, AFileOrFolderOfSomebodyElseIsRefused) {
  constexpr uid_t kNobody = 65534;
  const auto file = Write("qos = 1\n");
  const auto folder = file.parent_path();
  if (chown(file.c_str(), kNobody, 0) != 0) GTEST_SKIP() << "only root can give files away";
  const std::vector<std::string> look = {"config", "show"};
  const Finished of_another = Fleetpub(look);
  EXPECT_EQ(of_another.exit_code, 2);
  EXPECT_THAT(of_another.errors, AllOf(HasSubstr("refused"), HasSubstr("belongs to nobody")));
  EXPECT_EQ(Fleetpub({"config", "show", "--config", file.string()}).exit_code, 0)
      << "root named it outright";
  ASSERT_EQ(chown(file.c_str(), 0, 0), 0);
  ASSERT_EQ(chown(folder.c_str(), kNobody, 0), 0);
  const Finished in_anothers = Fleetpub(look);
  EXPECT_EQ(in_anothers.exit_code, 2);
  EXPECT_THAT(in_anothers.errors, HasSubstr(folder.string() + " belongs to nobody"));
  ASSERT_EQ(chown(folder.c_str(), 0, 0), 0);
  EXPECT_EQ(Fleetpub(look).exit_code, 0);
}

TEST_F(Configuration, AFolderThatEverybodyCanWriteInIsRefused) {
  const auto file = Write("qos = 1\n");
  const auto linked = operator_.home().path() / "elsewhere.toml";
  std::filesystem::create_symlink(file, linked);
  for (const auto& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    chmod(folder.c_str(), 0777);
    for (const auto& name : {file, linked}) {
      const Finished run = Fleetpub({"config", "show", "--config", name.string()});
      EXPECT_EQ(run.exit_code, 2) << name;
      EXPECT_THAT(run.errors, HasSubstr("chmod o-w " + folder.string() + "\n"));
    }
    chmod(folder.c_str(), 01777);
    EXPECT_EQ(Fleetpub({"config", "show"}).exit_code, 0) << "sticky: nobody can replace it";
    chmod(folder.c_str(), 0770);
    EXPECT_EQ(Fleetpub({"config", "show"}).exit_code, 0) << "a group may";
  }
}

TEST_F(Configuration, AFifoIsNotWaitedForButAPipeIs) {
  const auto file = Write("");
  std::filesystem::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  const Finished fifo = Fleetpub({"pause", "KIT/0001", "--dry-run"});
  EXPECT_EQ(fifo.exit_code, 2);
  EXPECT_THAT(fifo.errors, HasSubstr("FIFO"));
  Command command = operator_.Prepare({});
  command.arguments = {"bash", "-c",
                       Binary() + " config show -o json --config <(sleep 0.1; echo 'qos = 2')"};
  const Finished piped = testing::Run(command);
  EXPECT_EQ(piped.exit_code, 0) << piped.errors;
  EXPECT_THAT(Shown(piped, "qos"), HasSubstr("2 | /dev/fd/"));
}

TEST_F(Configuration, TooDeepAKeyIsRefused) {
  std::string key;
  for (int i = 0; i < 30'000; ++i) key += "a.";
  for (const std::string& text :
       {key + "a = 1\n", "[" + key + "a]\n", "x = {" + key + "a = 1}\n"}) {
    Write(text);
    const Finished run = Fleetpub({"pause", "KIT/0001", "--dry-run"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr("64 levels"));
  }
}

TEST_F(Configuration, HelpAndInitNeedNoRightFile) {
  const auto file = Write("nonsense");
  EXPECT_EQ(Fleetpub({"pause", "--help"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"--version"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"config", "init", "--stdout"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"config", "init", "-"}).exit_code, 0);
}

// ── config init ──

TEST_F(Configuration, TheStarterIsWrittenOnceForItsOwnerOnly) {
  const Finished run = Fleetpub({"config", "init"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto file = operator_.home() / ".config/fleetpub/config.toml";
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_EQ(Fleetpub({"config", "show"}).exit_code, 0);
  std::ofstream(file) << "qos = 1\n";
  const Finished again = Fleetpub({"config", "init"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.errors, HasSubstr("stays as it is"));
  EXPECT_EQ(std::filesystem::file_size(file), 8U);
}

TEST_F(Configuration, TheStartersLinesAreAllRightAndAllThatThereAre) {
  std::string text;
  for (const std::string& line : Lines(Fleetpub({"config", "init", "--stdout"}).output)) {
    if (line.size() > 1 && line[0] == '#' && line[1] != ' ') text += line.substr(1) + "\n";
  }
  Write(text);
  const Finished run = Fleetpub({"config", "show", "-o", "json", "--profile", ""});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  for (const std::string& line : Lines(run.output)) {
    EXPECT_THAT(line, Not(HasSubstr("\"origin\":\"default\"")));
  }
}

// ── targets ──

constexpr const char* kMixedFleet =
    "[robot.\"KIT/0001\"]\nalias = \"old\"\nvda = \"2.0\"\nactions_key = \"instantActions\"\n"
    "header_serial = \"1\"\n"
    "[robot.\"KIT/0002\"]\nalias = \"new\"\ninterface = \"plant\"\n"
    "[group]\nhall = [\"old\", \"new\"]\nsolo = [\"new\"]\n";

TEST_F(Configuration, EachRobotIsSpokenToInItsOwnWay) {
  Write(kMixedFleet);
  const Finished run = Fleetpub({"pause", "@hall", "KIT/0003", "--dry-run", "-o", "json"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  std::vector<std::string> topics;
  for (const std::string& line : Lines(run.output))
    topics.push_back(Json(line)["topic"].GetString());
  EXPECT_THAT(topics,
              ElementsAre("uagv/v2/KIT/0001/instantActions", "plant/v3/KIT/0002/instantActions",
                          "vda5050/v3/KIT/0003/instantActions"));
  const auto report = Json(Lines(run.output).front());
  const auto& payload = report["payload"];
  EXPECT_TRUE(payload.HasMember("instantActions"));
  EXPECT_STREQ(payload["serialNumber"].GetString(), "1");
  EXPECT_STREQ(payload["version"].GetString(), "2.0.0");
  const Finished flags = Fleetpub({"pause", "old", "--vda", "2.1", "--actions-key", "actions",
                                   "--interface", "x", "--dry-run", "-o", "json"});
  EXPECT_STREQ(Json(flags.output)["topic"].GetString(), "x/v2/KIT/0001/instantActions");
  EXPECT_STREQ(Json(flags.output)["version"].GetString(), "2.1.0");
}

TEST_F(Configuration, ABatchSpeaksToEachRobotInItsOwnWayToo) {
  Write("interface = \"plant\"\n" + std::string(kMixedFleet));
  Command batch = operator_.Prepare({"batch", "--dry-run"});
  batch.input =
      "{\"target\":[\"old\",\"KIT/0003\"],\"action\":\"startPause\"}\n"
      "{\"target\":\"old\",\"action\":\"startPause\",\"vda\":\"2.1\"}\n";
  const auto lines = Lines(testing::Run(std::move(batch)).output);
  ASSERT_THAT(lines, SizeIs(3));
  const auto first = Json(lines[0]);
  EXPECT_STREQ(first["version"].GetString(), "2.0.0");
  EXPECT_TRUE(first["payload"].HasMember("instantActions"));
  EXPECT_STREQ(Json(lines[1])["topic"].GetString(), "plant/v3/KIT/0003/instantActions");
  EXPECT_STREQ(Json(lines[2])["version"].GetString(), "2.1.0");
}

TEST_F(Configuration, AProfileAndAVariableThatNameDifferentBrokersAreRefused) {
  const Mosquitto broker;
  const Mosquitto other;
  Write("[profile.north]\nbroker = \"" + broker.Url() + "\"\n");
  const Subscriber subscriber(other);
  const std::vector<std::string> pause = WithoutLook({"pause", "KIT/0001", "--profile", "north"});
  const Finished refused = FleetpubWith("FLEETPUB_BROKER", other.Url(), pause);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("profile north has the broker " + broker.Url()),
                                    HasSubstr("FLEETPUB_BROKER names another")));
  EXPECT_EQ(FleetpubWith("FLEETPUB_BROKER", broker.Url(), pause).exit_code, 0);
  EXPECT_EQ(FleetpubWith("FLEETPUB_HOST", "127.0.0.1", pause).exit_code, 2);
  const Finished shown = FleetpubWith("FLEETPUB_BROKER", other.Url(),
                                      {"config", "show", "--profile", "north", "-o", "json"});
  EXPECT_EQ(Shown(shown, "broker"), other.Url() + " | environment variable FLEETPUB_BROKER");
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
}

TEST_F(Configuration, AFlagForTheBrokerGoesBeforeTheVariableOfTheOtherForm) {
  const Mosquitto broker;
  const std::string port = std::to_string(broker.port());
  const Finished by_host =
      FleetpubWith("FLEETPUB_BROKER", "mqtt://127.0.0.1:1",
                   WithoutLook({"pause", "KIT/0001", "--host", "127.0.0.1", "-p", port}));
  EXPECT_EQ(by_host.exit_code, 0) << by_host.errors;
  const Finished by_url = FleetpubWith("FLEETPUB_HOST", "nobody.invalid",
                                       WithoutLook({"pause", "KIT/0001", "-b", broker.Url()}));
  EXPECT_EQ(by_url.exit_code, 0) << by_url.errors;
  const Finished unclear =
      FleetpubWith("FLEETPUB_BROKER", broker.Url(), {"pause", "KIT/0001", "-p", port});
  EXPECT_EQ(unclear.exit_code, 2);
  EXPECT_THAT(unclear.errors, HasSubstr("FLEETPUB_BROKER"));
}

TEST_F(Configuration, AGroupIsCommandedOnlyWithAWord) {
  const Mosquitto broker;
  Write("broker = \"" + broker.Url() + "\"\nqos = 1\n" + std::string(kMixedFleet));
  const Subscriber subscriber(broker);
  const Finished refused = Send({"cancelOrder", "@hall"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("--yes"), HasSubstr("KIT/0001, KIT/0002")));
  EXPECT_THAT(subscriber.SoFar(), IsEmpty());
  EXPECT_EQ(Send({"cancelOrder", "@hall", "--yes"}).exit_code, 0);
  EXPECT_EQ(Send({"cancelOrder", "@solo"}).exit_code, 0);
  EXPECT_EQ(Send({"pause", "@hall"}).exit_code, 0);
  EXPECT_THAT(subscriber.Await(5), SizeIs(5));
}

TEST_F(Configuration, AGroupIsAskedForOnATerminal) {
  const Mosquitto broker;
  Write("broker = \"" + broker.Url() + "\"\nqos = 1\n" + std::string(kMixedFleet));
  const auto answer = [&](const std::string& text) {
    Command command = operator_.Prepare({"cancelOrder", "@hall"});
    const std::string call = command.arguments[0] + " cancelOrder @hall --vda 3 --no-check";
    command.arguments = {"script", "-qec", call, "/dev/null"};
    command.input = std::nullopt;
    Process process(std::move(command));
    EXPECT_TRUE(process.AwaitOutput("Send cancelOrder to 2 robots at " + broker.Url() + "? [y/N]"))
        << process.Output();
    process.Write(text + "\n");
    const auto code = process.Wait();
    return std::pair(code, process.Output());
  };
  const auto [no, told] = answer("n");
  EXPECT_EQ(no, 2);
  EXPECT_THAT(told, AllOf(HasSubstr("KIT/0001, KIT/0002"), HasSubstr("nothing was sent")));
  EXPECT_EQ(answer("y").first, 0);
}

TEST_F(Configuration, AMixedGroupConfirmsRobotByRobot) {
  const Mosquitto broker;
  Write("broker = \"" + broker.Url() + "\"\n" + std::string(kMixedFleet));
  Process old(operator_.Prepare({"simulate", "old"}));
  Process young(operator_.Prepare({"simulate", "new", "--vda", "3"}));
  ASSERT_TRUE(old.AwaitErrors("online at")) << old.Errors();
  ASSERT_TRUE(young.AwaitErrors("online at")) << young.Errors();
  const Finished run = Fleetpub({"pause", "@hall", "--wait", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  std::vector<std::string> versions;
  for (const std::string& line : Lines(run.output)) {
    if (Json(line).HasMember("summary")) continue;
    EXPECT_STREQ(Json(line)["status"].GetString(), "FINISHED");
    versions.emplace_back(Json(line)["version"].GetString());
  }
  EXPECT_THAT(versions, UnorderedElementsAre("2.0.0", "3.0.0"));
  EXPECT_EQ(Fleetpub({"await", "old", "connection", "connectionState=ONLINE"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"await", "@hall", "connection", "connectionState=ONLINE"}).exit_code, 0);
  EXPECT_THAT(Fleetpub({"fleet", "@hall", "--state-wait", "0"}).output,
              AllOf(HasSubstr("KIT/0001"), HasSubstr("KIT/0002")));
  EXPECT_THAT(Fleetpub({"fleet", "old", "--state-wait", "0"}).output, HasSubstr("KIT/0001"));
  EXPECT_THAT(Lines(Fleetpub({"history", "--target", "old", "-o", "json"}).output), SizeIs(1));
}

TEST_F(Configuration, OneRobotMayBeAutomaticBesideOthers) {
  const Mosquitto broker;
  Write("broker = \"" + broker.Url() + "\"\nvda = \"3.0\"\n[robot.\"KIT/0001\"]\nvda = \"auto\"\n");
  Process robot(operator_.Prepare({"simulate", "KIT/0001", "--vda", "1.1"}));
  ASSERT_TRUE(robot.AwaitErrors("online at")) << robot.Errors();
  const Finished run = Fleetpub({"pause", "KIT/0001", "KIT/0002", "--no-check", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_STREQ(Json(Lines(run.output)[0])["version"].GetString(), "1.1.0");
  EXPECT_STREQ(Json(Lines(run.output)[1])["version"].GetString(), "3.0.0");
}

// ── secrets ──

TEST_F(Configuration, NoPasswordComesOut) {
  const Mosquitto broker({"password_file {}/users"}, {{"users", PasswordFile("me", "hunter2")}});
  const auto password = operator_.home().Write("pw", "hunter2\n");
  chmod(password.c_str(), 0600);
  Write("broker = \"" + broker.Url() + "\"\nusername = \"me\"\npassword_file = \"" +
        password.string() + "\"\n");
  std::string all;
  const auto collect = [&](const Finished& run) { all += run.output + run.errors; };
  const Finished sent = Send({"pause", "KIT/0001", "-q", "1", "--debug", "-v"});
  EXPECT_EQ(sent.exit_code, 0) << sent.errors;
  collect(sent);
  collect(Fleetpub({"config", "show"}));
  EXPECT_THAT(all, HasSubstr("********"));
  collect(Fleetpub({"config", "show", "-o", "json"}));
  collect(Fleetpub({"history", "-o", "json"}));
  collect(Fleetpub({"history", "show", "1"}));
  collect(
      FleetpubWith("FLEETPUB_PASSWORD", "hunter2x", WithoutLook({"pause", "KIT/0001", "--debug"})));
  collect(FleetpubWith("FLEETPUB_PASSWORD", "hunter2", {"config", "show"}));
  collect(FleetpubWith("FLEETPUB_BROKER", "mqtt://me:hunter2@host", {"config", "show"}));
  collect(FleetpubWith("FLEETPUB_PROXY", "http://me:hunter2@host", {"config", "show"}));
  EXPECT_THAT(all, Not(HasSubstr("hunter2")));
}

TEST_F(Configuration, TheEnvironmentsPasswordGoesBeforeTheConfiguredFile) {
  const Mosquitto broker({"password_file {}/users"}, {{"users", PasswordFile("me", "right")}});
  const auto password = operator_.home().Write("pw", "wrong\n");
  chmod(password.c_str(), 0600);
  Write("broker = \"" + broker.Url() + "\"\nusername = \"me\"\npassword_file = \"" +
        password.string() + "\"\n");
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 4);
  EXPECT_EQ(
      FleetpubWith("FLEETPUB_PASSWORD", "right", WithoutLook({"pause", "KIT/0001"})).exit_code, 0);
}

TEST_F(Configuration, ThePasswordIsNotInWhatOtherUsersSeeOfTheProcess) {
  const Mosquitto broker({"password_file {}/users"}, {{"users", PasswordFile("me", "hunter2")}});
  const auto password = operator_.home().Write("pw", "hunter2\n");
  chmod(password.c_str(), 0644);
  Write("broker = \"" + broker.Url() + "\"\nusername = \"me\"\npassword_file = \"" +
        password.string() + "\"\n");
  Process watching(operator_.Prepare({"watch", "-o", "json"}));
  EXPECT_TRUE(watching.AwaitErrors("can be read by others: chmod 600"));
  const std::string process = "/proc/" + std::to_string(watching.pid());
  for (const char* name : {"/cmdline", "/comm", "/environ"}) {
    std::ostringstream text;
    text << std::ifstream(process + name).rdbuf();
    EXPECT_THAT(text.str(), Not(HasSubstr("hunter2"))) << name;
  }
}

// ── config check, path, profiles ──

TEST_F(Configuration, CheckTellsAllMistakesAtOnceInTheirOrder) {
  const std::string file = Write(
                               "qos = 7\n"
                               "[robot.\"KIT/0001\"]\nalias = \"a b\"\nvda = \"9\"\n"
                               "[profile.north]\nbrocker = \"mqtt://x\"\ninsecure = true\n"
                               "[group]\nhall = [\"nobody\", \"KIT/+\"]\n")
                               .string();
  const Finished run = Fleetpub({"config", "check"});
  EXPECT_EQ(run.exit_code, 2);
  std::vector<std::string> places;
  for (const std::string& line : Lines(run.output)) {
    ASSERT_THAT(line, StartsWith(file + ":"));
    places.push_back(line.substr(file.size() + 1, 1));
  }
  EXPECT_THAT(places, ElementsAre("1", "3", "4", "6", "7", "9", "9"));
  const Finished json = Fleetpub({"config", "check", "-o", "json"});
  EXPECT_EQ(json.exit_code, 2);
  EXPECT_EQ(Lines(json.output).size(), 7U);
  EXPECT_THAT(Json(Lines(json.output)[0])["message"].GetString(), HasSubstr("qos"));
}

TEST_F(Configuration, CheckKnowsWhatOnlyAnOptionKnows) {
  const std::pair<std::string, std::string> cases[] = {
      {"keep_alive = 70000", "keep_alive"},
      {"keep_alive = -1", "keep_alive"},
      {"user_property = [\"a=b\", \"plain\"]", "user_property"},
      {"message_expiry = \"0s\"", "message_expiry"},
      {"tls_server_name = \"mqtts://x\"", "tls_server_name"},
      {"tls_alpn = [\"\"]", "tls_alpn"},
      {"soar_prefix = \"a/b\"", "soar_prefix"},
      {"interface = \"hall/uagv\"", "interface"},
      {"topic_template = \"{interface}/x/{topic}\"", "{serial}"},
  };
  for (const auto& [line, words] : cases) {
    const std::string file = Write("[profile.south]\n" + line + "\n").string();
    const Finished run = Fleetpub({"config", "check"});
    EXPECT_EQ(run.exit_code, 2) << line;
    EXPECT_THAT(Lines(run.output), ElementsAre(AllOf(StartsWith(file + ":2:"), HasSubstr(words))))
        << line;
  }
}

TEST_F(Configuration, CheckIsContentWithWhatIsRight) {
  EXPECT_EQ(Fleetpub({"config", "check"}).exit_code, 0);
  const std::string file = Write("qos = 1\n").string();
  const Finished run = Fleetpub({"config", "check"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr(file));
  EXPECT_EQ(Fleetpub({"config", "check", "--config", "/no/such/file"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"config", "check", "--profile", "nowhere"}).exit_code, 2);
  Write("qos = \n");
  EXPECT_EQ(Fleetpub({"config", "check"}).exit_code, 2);
}

TEST_F(Configuration, PathNamesTheFilesThatAreRead) {
  const Finished before = Fleetpub({"config", "path"});
  EXPECT_EQ(before.exit_code, 0);
  EXPECT_THAT(Lines(before.output).back(), HasSubstr("(not there)"));
  const std::string file = Write("this is wrong").string();
  const Finished run = Fleetpub({"config", "path", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0);
  const auto lines = Lines(run.output);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_STREQ(Json(lines[0])["file"].GetString(), "/etc/fleetpub/config.toml");
  EXPECT_EQ(Json(lines[1])["file"].GetString(), file);
  EXPECT_TRUE(Json(lines[1])["exists"].GetBool());
  EXPECT_EQ(Fleetpub({"config", "path", "--config", "mine.toml"}).output,
            "mine.toml  (not there)\n");
}

TEST_F(Configuration, ProfilesAreListedWithTheirBrokers) {
  EXPECT_EQ(Fleetpub({"config", "profiles", "-o", "json"}).output, "");
  Write(
      "broker = \"mqtt://general\"\ndefault_profile = \"north\"\n"
      "[profile.north]\nbroker = [\"mqtt://n1\", \"mqtt://n2\"]\n[profile.south]\nqos = 1\n");
  const auto lines = Lines(Fleetpub({"config", "profiles", "-o", "json"}).output);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_STREQ(Json(lines[0])["profile"].GetString(), "north");
  EXPECT_EQ(Json(lines[0])["brokers"].Size(), 2U);
  EXPECT_TRUE(Json(lines[0])["default"].GetBool());
  EXPECT_STREQ(Json(lines[1])["brokers"][0].GetString(), "mqtt://general");
  EXPECT_FALSE(Json(lines[1])["default"].GetBool());
  EXPECT_THAT(Fleetpub({"config", "profiles"}).output,
              HasSubstr("north  mqtt://n1, mqtt://n2  (default)"));
}

}  // namespace
}  // namespace fleetpub::testing
