// `fleetpub doctor` at real brokers: what it finds, what it suggests, and how it ends.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <map>

#include "support/free_port.h"
#include "support/operator.h"
#include "support/publish_packet.h"
#include "support/scripted_broker.h"
#include "support/suggestions.h"
#include "support/terminal.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

constexpr const char* kHeader =
    R"("headerId":1,"timestamp":"2026-03-04T05:06:07.000Z","version":"3.0.0",)"
    R"("manufacturer":"KIT","serialNumber":"0001")";

// What it said with -o json.
struct Examined {
  int exit_code = -1;
  std::vector<base::JsonDocument> findings;
  base::JsonDocument summary;
  std::string errors;

  /// How bad a check is, of one subject or of any: `problem`, else `warning` …; "": it is not there.
  [[nodiscard]] std::string Health(const std::string& check,
                                   const std::string& subject = "") const {
    std::string worst;
    for (const char* health : {"ok", "unknown", "warning", "problem"}) {
      for (const auto& found : findings) {
        const bool is_meant = found["check"].GetString() == check &&
                              (subject.empty() || found["subject"].GetString() == subject);
        if (is_meant && found["health"].GetString() == std::string(health)) worst = health;
      }
    }
    return worst;
  }
  /// A member of the first finding of this check that is none of `ok`.
  [[nodiscard]] std::string Find(const std::string& check, const char* member) const {
    for (const auto& found : findings) {
      if (found["check"].GetString() != check || found["health"] == "ok") continue;
      return found.HasMember(member) ? found[member].GetString() : "";
    }
    return "";
  }
  /// What has a warning or is a problem.
  [[nodiscard]] std::vector<std::string> Bad() const {
    std::vector<std::string> bad;
    for (const auto& found : findings) {
      if (found["health"] == "ok" || found["health"] == "unknown") continue;
      bad.push_back(std::string(found["check"].GetString()) + ": " + found["message"].GetString());
    }
    return bad;
  }
};

// That of mosquitto which refuses subscriptions; its ACL file cannot.
std::string FindPlugin() {
  const Finished found =
      fleetpub::testing::Run({{"sh", "-c", "ls /usr/lib/*/mosquitto_dynamic_security.so"}});
  EXPECT_EQ(found.exit_code, 0) << found.errors;
  return found.output.substr(0, found.output.find('\n'));
}

class Doctor : public EndToEnd {
 protected:
  using Variables = std::vector<std::pair<std::string, std::optional<std::string>>>;

  [[nodiscard]] Examined Examine(std::vector<std::string> more,
                                 const Variables& variables = {}) const {
    more.insert(more.begin(), "doctor");
    more.insert(more.end(), {"-o", "json"});
    Command command = operator_.Prepare(std::move(more));
    command.environment.insert(command.environment.end(), variables.begin(), variables.end());
    const Finished run = fleetpub::testing::Run(std::move(command));
    Examined examined{.exit_code = run.exit_code, .errors = run.errors};
    for (const std::string& line : Lines(run.output)) {
      auto object = Json(line);
      if (object.HasMember("check")) {
        examined.findings.push_back(std::move(object));
      } else if (object.HasMember("summary")) {
        examined.summary = std::move(object);
        EXPECT_EQ(examined.summary["summary"]["exitCode"].GetInt(), run.exit_code);
      }
    }
    return examined;
  }
  void Configure(const std::string& text) const {
    chmod(operator_.home().Write(".config/fleetpub/config.toml", text).c_str(), 0600);
  }
  [[nodiscard]] std::string Secret(const std::string& name, const std::string& text) const {
    const auto file = operator_.home().Write(name, text);
    chmod(file.c_str(), 0600);
    return file.string();
  }
  static std::unique_ptr<Mosquitto> Guarded(const std::string& password) {
    return std::make_unique<Mosquitto>(
        std::vector<std::string>{"allow_anonymous false", "password_file {}/users"},
        std::vector<std::pair<std::string, std::string>>{{"users", PasswordFile("ann", password)}});
  }
};

TEST_F(Doctor, FindsNothingInAHealthyWorld) {
  const auto robots = Robot({"KIT/0001", "ACME/7", "--state-interval", "200ms"});
  const auto old = Robot({"KIT/0002", "--vda", "1.1", "--state-interval", "200ms"});
  const Examined examined = Examine({"--for", "700ms"});
  EXPECT_EQ(examined.exit_code, 0) << examined.errors;
  EXPECT_THAT(examined.Bad(), SizeIs(0)) << ::testing::PrintToString(examined.Bad());
  for (const auto& found : examined.findings) {
    EXPECT_TRUE(found["health"] == "ok" || found["check"] == "publish")
        << found["check"].GetString();
  }
  EXPECT_EQ(examined.summary["summary"]["robots"].GetInt(), 3);
  EXPECT_EQ(Fleetpub({"doctor", "--for", "300ms", "--quiet"}).output, "");
  EXPECT_THAT(Lines(Fleetpub({"history", "-o", "json"}).output), SizeIs(0));
}

TEST_F(Doctor, TellsEachFaultOfRobots) {
  struct Row {
    const char* fault;
    const char* check;
    const char* health;
  };
  const Row rows[] = {
      {"header-id-zero", "header-ids", "problem"},
      {"header-id-restart", "header-ids", "warning"},
      {"lose-states", "header-ids", "warning"},
      {"header-version", "version", "problem"},
      {"header-name", "names", "problem"},
      {"local-time", "clock", "warning"},
      {"connection-not-retained", "connection", "problem"},
      {"factsheet-not-retained", "factsheet", "problem"},
      {"factsheet-without-actions", "factsheet", "warning"},
  };
  std::vector<std::unique_ptr<Process>> robots;
  for (const Row& row : rows) {
    robots.push_back(Robot(
        {std::string("KIT/") + row.fault, "--fault", row.fault, "--state-interval", "100ms"}));
  }
  const Examined examined = Examine({"--for", "1500ms"});
  for (const auto& [fault, check, health] : rows) {
    EXPECT_EQ(examined.Health(check, std::string("KIT/") + fault), health) << fault;
  }
  EXPECT_EQ(examined.exit_code, 7) << "7 goes before 3";
}

TEST_F(Doctor, FindsARetainedOrderAndSaysHowToDeleteIt) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "200ms"});
  Say("vda5050/v3/KIT/0001/order", "{}", true);
  const Examined examined = Examine({"--for", "400ms"});
  EXPECT_EQ(examined.exit_code, 3);
  EXPECT_EQ(examined.Health("retained"), "problem");
  const std::string remedy = examined.Find("retained", "try");
  EXPECT_EQ(fleetpub::testing::Run({{"sh", "-c", remedy}}).exit_code, 0) << remedy;
  EXPECT_EQ(Examine({"--for", "400ms"}).exit_code, 0);
}

TEST_F(Doctor, FindsRobotsAtTwoPlacesAndThoseThatAreAwayAndSpeak) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "100ms"});
  const std::string header = kHeader;
  Say("uagv/v2/KIT/0001/connection", "{" + header + R"(,"connectionState":"ONLINE"})", true);
  Say("vda5050/v3/KIT/0001/connection", "{" + header + R"(,"connectionState":"OFFLINE"})", true);
  const Examined examined = Examine({"--for", "400ms"});
  EXPECT_EQ(examined.Health("places"), "problem");
  EXPECT_EQ(examined.Health("online"), "warning");
  EXPECT_EQ(examined.Health("version"), "problem") << "3.0.0 below v2";
}

TEST_F(Doctor, LooksForRobotsThatAreNamedOrWereCommanded) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "200ms"});
  EXPECT_EQ(Examine({"KIT/0001", "--for", "300ms"}).exit_code, 0);
  const Examined missing = Examine({"KIT/0001", "KIT/0009", "--for", "300ms"});
  EXPECT_EQ(missing.exit_code, 7);
  EXPECT_EQ(missing.Health("presence", "KIT/0009"), "problem");
  EXPECT_EQ(missing.summary["summary"]["robots"].GetInt(), 1);
  EXPECT_EQ(Examine({"--except", "KIT/0001", "--for", "300ms"}).exit_code, 7) << "nobody is left";
  EXPECT_EQ(Send({"pause", "KIT/0008"}).exit_code, 0);
  const Examined commanded = Examine({"--for", "300ms"});
  EXPECT_EQ(commanded.exit_code, 0);
  EXPECT_EQ(commanded.Health("presence", "KIT/0008"), "warning");
  EXPECT_EQ(commanded.Health("publish"), "unknown") << "it did not answer";
  EXPECT_EQ(Fleetpub({"stateRequest", "KIT/0001", "--wait"}).exit_code, 0);
  EXPECT_EQ(Examine({"--for", "300ms"}).Health("publish"), "ok");
}

TEST_F(Doctor, TakesTargetsFromStandardInput) {
  const auto robots = Robot({"KIT/0001", "KIT/0002", "--state-interval", "200ms"});
  Command command = operator_.Prepare({"doctor", "-", "--for", "300ms", "-o", "json"});
  command.input = "KIT/0002\n";
  const Finished run = fleetpub::testing::Run(std::move(command));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(Json(Lines(run.output).back())["summary"]["robots"].GetInt(), 1);
}

TEST_F(Doctor, JudgesARecordingByTheTimesOfThen) {
  const std::string online =
      std::string(R"({\"headerId\":1,\"timestamp\":\"2026-03-04T05:06:07.000Z\",)") +
      R"(\"version\":\"3.0.0\",\"manufacturer\":\"KIT\",\"serialNumber\":\"0001\",)" +
      R"(\"connectionState\":\"ONLINE\"})";
  const auto line = [](const char* time, const std::string& topic, const std::string& payload) {
    return std::string(R"({"tst":"2026-03-04T05:)") + time +
           R"(.000000Z+0000","topic":"vda5050/v3/)" + topic +
           R"(","qos":0,"retain":1,"payload":")" + payload + "\"}\n";
  };
  const auto file =
      operator_.home().Write("a.jsonl", line("06:07", "KIT/0001/connection", online) +
                                            line("06:50", "KIT/0002/connection", "{}"));
  const Examined examined = Examine({"KIT/0001", "--from", file.string()});
  EXPECT_EQ(examined.Health("online", "KIT/0001"), "problem");
  EXPECT_EQ(examined.Health("broker"), "unknown");
  EXPECT_EQ(examined.exit_code, 6) << examined.errors;
  EXPECT_EQ(Fleetpub({"doctor", "--from", file.string(), "--for", "1s"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"doctor", "--from", (operator_.home() / "none").string()}).exit_code, 8);
}

TEST_F(Doctor, ReachesTheBrokersOfAllProfiles) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "200ms"});
  const std::string south = "mqtt://127.0.0.1:" + std::to_string(FreePort());
  Configure("default_profile = \"north\"\n[profile.north]\nbroker = \"" + broker_.Url() +
            "\"\n[profile.south]\nbroker = \"" + south + "\"\n");
  operator_.UseBroker("");
  const Examined all = Examine({"--for", "300ms"});
  EXPECT_EQ(all.exit_code, 4);
  EXPECT_EQ(all.Health("broker", south + " (profile south)"), "problem");
  EXPECT_EQ(all.Health("broker", broker_.Url() + " (profile north)"), "ok");
  EXPECT_EQ(all.summary["summary"]["robots"].GetInt(), 1);
  const Examined north = Examine({"--for", "300ms", "--profile", "north"});
  EXPECT_EQ(north.exit_code, 0);
  EXPECT_EQ(north.Health("broker", south + " (profile south)"), "");
  EXPECT_THAT(north.Find("publish", "try"), EndsWith("--profile north"));
}

TEST_F(Doctor, SendsEachLoginToItsOwnBroker) {
  const auto north = Guarded("of north");
  const auto south = Guarded("of south");
  Configure("default_profile = \"north\"\n[profile.north]\nusername = \"ann\"\nbroker = \"" +
            north->Url() + "\"\n[profile.south]\nusername = \"ann\"\npassword_file = \"" +
            Secret("south", "of south\n") + "\"\nbroker = \"" + south->Url() + "\"\n");
  operator_.UseBroker("");
  const Examined examined = Examine({"--for", "200ms"}, {{"FLEETPUB_PASSWORD", "of north"}});
  EXPECT_EQ(examined.Health("broker", north->Url() + " (profile north)"), "ok");
  EXPECT_EQ(examined.Health("broker", south->Url() + " (profile south)"), "ok");
  EXPECT_EQ(examined.exit_code, 7) << "nobody is there";
  EXPECT_THAT(south->Log(), Not(HasSubstr("not authorised")));
}

TEST_F(Doctor, TellsAWrongPasswordAndAFileThatOthersRead) {
  const auto guarded = Guarded("right");
  operator_.UseBroker(guarded->Url());
  const auto secret = Secret("password", "wrong\n");
  const Examined wrong = Examine({"-u", "ann", "--password-file", secret});
  EXPECT_EQ(wrong.exit_code, 4);
  EXPECT_EQ(wrong.Health("broker"), "problem");
  chmod(secret.c_str(), 0644);
  std::ofstream(secret) << "right\n";
  const Examined open = Examine({"-u", "ann", "--password-file", secret, "--for", "100ms"});
  EXPECT_EQ(open.Health("credentials"), "warning");
  EXPECT_EQ(open.Find("credentials", "try"), "chmod 600 " + secret);
  const Examined none = Examine({"-u", "ann", "--password-file", secret + "-not"});
  EXPECT_EQ(none.Health("credentials"), "problem");
  EXPECT_EQ(none.exit_code, 8);
}

TEST_F(Doctor, TellsOfAPasswordThatOthersCanReadOnce) {
  const auto guarded = Guarded("secret");
  operator_.UseBroker(guarded->Url());
  const auto file = operator_.home().Write("password", "secret\n");
  chmod(file.c_str(), 0644);
  const Examined examined =
      Examine({"--for", "100ms", "--username", "ann", "--password-file", file.string()});
  EXPECT_EQ(examined.Health("credentials"), "warning");
  EXPECT_THAT(examined.Find("credentials", "try"), HasSubstr("chmod 600"));
  EXPECT_THAT(examined.errors, Not(HasSubstr("can be read by others")));
}

TEST_F(Doctor, TellsOfACredentialThatOthersCanRead) {
  const auto guarded = Guarded("secret");
  operator_.UseBroker(guarded->Url());
  const auto file = operator_.home().Write("fleetpub.password", "secret\n");
  const Variables folder = {{"CREDENTIALS_DIRECTORY", operator_.home().path().string()}};
  for (const auto& [mode, health] : {std::pair(0600, "ok"), {0644, "warning"}}) {
    chmod(file.c_str(), static_cast<mode_t>(mode));
    EXPECT_EQ(Examine({"--for", "100ms", "--username", "ann"}, folder).Health("credentials"),
              health);
  }
}

TEST_F(Doctor, TellsWhatTheLoginMayNotSubscribeTo) {
  const std::string rights =
      R"({"defaultACLAccess":{"publishClientSend":true,"publishClientReceive":true,)"
      R"("subscribe":true,"unsubscribe":true},"clients":[],"groups":[{"groupname":"all",)"
      R"("roles":[{"rolename":"few"}],"clients":[]}],"roles":[{"rolename":"few","acls":[)"
      R"({"acltype":"subscribePattern","topic":"+/+/+/+/factsheet","priority":0,"allow":false},)"
      R"({"acltype":"subscribePattern","topic":"+/+/+/+/order","priority":0,"allow":false}]}],)"
      R"("anonymousGroup":"all"})";
  const Mosquitto broker(
      {"allow_anonymous true", "plugin " + FindPlugin(), "plugin_opt_config_file {}/rights.json"},
      {{"rights.json", rights}});
  operator_.UseBroker(broker.Url());
  const Examined examined = Examine({"--for", "100ms"});
  EXPECT_EQ(examined.exit_code, 4);
  EXPECT_THAT(examined.Bad(),
              AllOf(Contains(HasSubstr("/factsheet")), Contains(HasSubstr("/order"))));
  EXPECT_EQ(examined.Health("subscribe"), "problem");
}

TEST_F(Doctor, SaysWhenALoginMayHearNothing) {
  const Mosquitto deaf({"allow_anonymous true", "acl_file {}/acl"}, {{"acl", "topic write #\n"}});
  operator_.UseBroker(deaf.Url());
  const Examined examined = Examine({"--for", "100ms"});
  EXPECT_EQ(examined.exit_code, 7);
  EXPECT_THAT(examined.Find("presence", "message"), HasSubstr("may not read"));
}

TEST_F(Doctor, TellsAllMistakesOfTheConfigurationAndStopsThere) {
  for (const char* text : {"broker = [\n", "colour = 1\n[profile.a]\nqos = 7\n",
                           "keep_alive = 99999999\n", "default_profile = \"none\"\n"}) {
    Configure(text);
    const Examined examined = Examine({});
    EXPECT_EQ(examined.exit_code, 2) << text;
    EXPECT_EQ(examined.Health("settings"), "problem") << text;
    EXPECT_THAT(examined.Find("settings", "try"), HasSubstr("config check"));
    EXPECT_EQ(examined.Health("broker"), "");
  }
  EXPECT_THAT(broker_.Log(), Not(HasSubstr("New client")));
  EXPECT_EQ(Fleetpub({"doctor", "--proxy", "http://a:b@host:1"}).exit_code, 2) << "not forgiven";
}

TEST_F(Doctor, TellsALedgerThatCannotBeReadAndGoesOn) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "200ms"});
  const auto place = operator_.home().Write("ledger.db", std::string(8'192, 'x'));
  operator_.UseLedger(place.string());
  const Examined examined = Examine({"--for", "300ms"});
  EXPECT_EQ(examined.exit_code, 8);
  EXPECT_EQ(examined.Health("ledger"), "problem");
  EXPECT_EQ(examined.Health("presence"), "ok");
}

// By name it hands out what filters with wildcards did not bring, and takes its time.
TEST_F(Doctor, SaysThatNothingIsMissingBeforeABusyBrokerHasSpoken) {
  const auto retained = [](const std::string& topic_name, const std::string& members) {
    std::string packet = PublishPacket("vda5050/v3/KIT/0001/" + topic_name,
                                       std::string("{") + kHeader + "," + members + "}");
    packet[0] = static_cast<char>(packet[0] | 1);  // RETAIN (MQTT 3.1.1 §3.3.1.3)
    return packet;
  };
  const auto connection = retained("connection", R"("connectionState":"ONLINE")");
  const ScriptedBroker broker(
      {.after_suback = connection,
       .by_name = retained("factsheet", R"("protocolFeatures":{})") + connection,
       .before_by_name = std::chrono::milliseconds(900)});
  operator_.UseBroker(broker.Url());
  const Examined examined = Examine({"--for", "100ms"});
  EXPECT_NE(examined.Health("factsheet"), "problem") << examined.errors;
  EXPECT_EQ(examined.Health("connection"), "ok");
}

TEST_F(Doctor, SumsUpWhatAThousandRobotsHaveInCommon) {
  const auto robots = Robot({"KIT/0001", "--count", "1000", "--fault", "header-name"});
  const Finished run = Fleetpub({"doctor", "--for", "5s"});
  EXPECT_EQ(run.exit_code, 3) << run.errors;
  EXPECT_THAT(Lines(run.output), Contains(AllOf(HasSubstr("names"), HasSubstr("995 more"))));
  EXPECT_LT(Lines(run.output).size(), 60U);
  EXPECT_THAT(Lines(run.output).back(), HasSubstr("1000 problems")) << run.output;
}

TEST_F(Doctor, SuggestsWhatCanBeTyped) {
  const auto mute = Robot({"KIT/0001", "--fault", "header-id-zero", "--fault",
                           "factsheet-not-retained", "--state-interval", "100ms"});
  const Finished run = Fleetpub({"doctor", "--for", "500ms", "-b", broker_.Url()});
  const auto suggestions = FindSuggestions(run.output);
  EXPECT_GE(suggestions.size(), 2U) << run.output;
  EXPECT_THAT(suggestions, Each(HasSubstr("-b " + broker_.Url())));
  for (const std::string& line : suggestions) ExpectUnderstood(line);
}

TEST_F(Doctor, JudgesByWhatWasHeardOnCtrlC) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "100ms"});
  Process doctor(operator_.Prepare({"doctor", "--for", "1h", "-o", "json", "--debug"}));
  ASSERT_TRUE(doctor.AwaitErrors("KIT/0001/state")) << doctor.Errors();
  doctor.Signal(SIGINT);
  EXPECT_EQ(doctor.Wait(), 0) << doctor.Errors();
  EXPECT_THAT(doctor.Output(), HasSubstr(R"("check":"presence","health":"ok")"));
}

TEST_F(Doctor, FitsATerminalOf80Columns) {
  const auto robot =
      Robot({"KIT/0001", "--fault", "connection-not-retained", "--state-interval", "100ms"});
  Terminal terminal(ShellLine(operator_.Prepare({"doctor", "--for", "300ms"})) + "; sleep 100", 80,
                    50);
  ASSERT_TRUE(terminal.Await("nothing was sent"));
  EXPECT_THAT(terminal.Shown(), HasSubstr("\n    "));
}

}  // namespace
}  // namespace fleetpub::testing
