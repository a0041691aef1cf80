// SoAR with the real binary: messages, acknowledgements, virtual platforms, validation.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "base/json.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::SizeIs;

constexpr const char* kEco1 = "soar.planet-ocean.ecosub.eco1";

constexpr const char* kSquads = R"(
planning_config_ID = 3

[[squads]]
squad_ID = 1
no_of_platforms = 1
squad_mission_type = "survey"
squad_state = "waiting"
region_of_interest.geometry_coordinates = [[[-4.18, 50.37], [-4.20, 50.36], [-4.20, 50.35], [-4.18, 50.35]]]

[[squads.platforms]]
platform_ID = 1
serial = "eco1"
model = "ecosub"
min_altitude = 5.0
min_velocity = 0.1
max_velocity = 0.9
emergency = { latitude_waypoint = 50.35, longitude_waypoint = -4.2, target_depth = 0.0, safe_command = "go_home" }

[[squads]]
squad_ID = 2
no_of_platforms = 1
squad_mission_type = "inspection"
squad_state = "waiting"

[[squads.platforms]]
platform_ID = 2
serial = "ah1"
model = "autosub"
min_altitude = 10.0
min_velocity = 0.2
max_velocity = 1.5
emergency = { latitude_waypoint = 50.35, longitude_waypoint = -4.2, target_depth = 0.0 }

[[exclusion_zones]]
geometry_coordinates = [[[-4.19, 50.37], [-4.20, 50.37], [-4.20, 50.36], [-4.19, 50.36]]]
)";

class Soar : public EndToEnd {
 protected:
  // `fleetpub soar mission-plan DESTINATION` with one waypoint, and more arguments.
  static std::vector<std::string> Plan(const std::string& destination,
                                       const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "soar", "mission-plan", destination,          "--plan-id", "3", "--platform-id",
        "1",    "--waypoint",   "lat=50.37,lon=-4.19"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  // Platforms that are there when this returns.
  [[nodiscard]] std::unique_ptr<Process> Simulate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"simulate", "--protocol", "soar"});
    auto process = std::make_unique<Process>(operator_.Prepare(std::move(arguments)));
    EXPECT_TRUE(process->AwaitErrors(" online at ")) << process->Errors();
    return process;
  }
  // Says over mosquitto_pub what a control system would.
  void Say(const std::string& topic, const std::string& message) const {
    EXPECT_EQ(
        testing::Run({.arguments = {"mosquitto_pub", "-h", "127.0.0.1", "-p",
                                    std::to_string(broker_.port()), "-t", topic, "-m", message}})
            .exit_code,
        0);
  }
};

TEST_F(Soar, PublishesAMissionPlanOnThePlatformsTopic) {
  const Subscriber subscriber(broker_);
  const Finished run =
      Fleetpub(Plan(kEco1, {"--waypoint", "lon=-4.2,lat=50.36,depth=15,action=move", "--source",
                            "autonomy_engine"}));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(run.errors, "");
  EXPECT_THAT(run.output,
              MatchesRegex("soar.planet-ocean.ecosub.eco1  mission_plan  SENT  [0-9.]+ m?s\n"));
  const auto received = subscriber.Await(1);
  ASSERT_THAT(received, SizeIs(1));
  EXPECT_EQ(received[0].topic, "soar/planet-ocean/ecosub/eco1/to_platform/mission_plan");
  EXPECT_FALSE(received[0].retained);
  const auto message = Json(received[0].payload);
  std::vector<std::string> names;
  for (const auto& member : message["header"].GetObject())
    names.emplace_back(member.name.GetString());
  EXPECT_THAT(names, ElementsAre("message_ID", "timestamp", "version", "source", "destination",
                                 "delivery_type", "encoded"));
  EXPECT_STREQ(message["header"]["source"].GetString(), "autonomy_engine");
  EXPECT_STREQ(message["header"]["destination"].GetString(),
               "soar.planet-ocean.ecosub.eco1.to_platform.mission_plan");
  EXPECT_EQ(message["payload"]["plan"].Size(), 2U);
  EXPECT_EQ(message["payload"]["plan"][1]["depth"].GetDouble(), 15);
}

TEST_F(Soar, TakesTheDestinationBehindRepeatedOptions) {
  const Finished run =
      Fleetpub({"soar", "mission-plan", "--plan-id", "3", "--platform-id", "1", "--waypoint",
                "lat=1,lon=2", "--waypoint", "lat=3,lon=4", kEco1, "--dry-run", "-o", "json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto report = Json(run.output);
  EXPECT_STREQ(report["target"].GetString(), kEco1);
  EXPECT_EQ(report["payload"]["payload"]["plan"].Size(), 2U);
}

TEST_F(Soar, ReportsAPlanFromAFileExecutedByAVirtualPlatform) {
  const auto platform = Simulate({kEco1});
  operator_.home().Write("plan.csv", "lat,lon,depth\n50.37,-4.19,15\n50.36,-4.2,\n50.35,-4.2,0\n");
  const Finished run =
      Fleetpub({"soar", "mission-plan", kEco1, "--plan-id", "3", "--platform-id", "1", "--plan",
                operator_.home() / "plan.csv", "--each", "action=move", "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, MatchesRegex("soar.planet-ocean.ecosub.eco1  mission_plan  FINISHED  "
                                       "[0-9.]+ m?s  executed\n"));
  EXPECT_THAT(Lines(run.errors),
              ElementsAre(HasSubstr("soar.planet-ocean.ecosub.eco1: c2_received"),
                          HasSubstr("operator_approved_and_sent"), HasSubstr("executed")));
}

TEST_F(Soar, WaitsForTheLevelThatIsAskedFor) {
  const auto platform = Simulate({kEco1, "--stop-at", "operator_approved_and_sent"});
  const Finished early = Fleetpub(Plan(kEco1, {"--wait-for", "c2_received", "--quiet"}));
  EXPECT_EQ(early.exit_code, 0);
  EXPECT_EQ(early.errors, "") << "--quiet";
  const Finished late = Fleetpub(Plan(kEco1, {"--wait", "-W", "300ms", "-o", "json"}));
  EXPECT_EQ(late.exit_code, 6);
  const auto report = Json(late.output);
  EXPECT_STREQ(report["status"].GetString(), "TIMEOUT");
  EXPECT_STREQ(report["message"].GetString(), "operator_approved_and_sent");
  EXPECT_STREQ(report["protocol"].GetString(), "soar");
  EXPECT_FALSE(report.HasMember("headerId"));
}

TEST_F(Soar, SaysWhenNobodyAcknowledges) {
  const auto platform = Simulate({kEco1, "--silent"});
  const Finished run = Fleetpub(Plan(kEco1, {"--wait", "-W", "200ms"}));
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_THAT(run.output, HasSubstr("TIMEOUT"));
  EXPECT_THAT(run.output, HasSubstr("nobody acknowledged it"));
}

TEST_F(Soar, TakesTheTimeThatThePlatformTakes) {
  const auto platform = Simulate({kEco1, "--delay", "150ms"});
  const Finished run = Fleetpub(Plan(kEco1, {"--wait", "-o", "json"}));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_GE(Json(run.output)["elapsedMs"].GetDouble(), 290);
}

TEST_F(Soar, BroadcastsAPlanningConfigurationFromToml) {
  const auto platforms = Simulate({kEco1, "soar.noc.autosub.ah1"});
  const Subscriber subscriber(broker_, "soar/broadcast");
  operator_.home().Write("squads.toml", kSquads);
  const Finished run =
      Fleetpub({"soar", "planning-configuration", "--broadcast", "--file",
                operator_.home() / "squads.toml", "--strict", "--wait", "--acks", "2"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("broadcast  planning_configuration  FINISHED"),
                                HasSubstr("2 of 2 executed")));
  EXPECT_THAT(run.errors, HasSubstr("soar.noc.autosub.ah1: executed"));
  const auto received = subscriber.Await(1);
  ASSERT_THAT(received, SizeIs(1));
  const auto message = Json(received[0].payload);
  EXPECT_STREQ(message["header"]["delivery_type"].GetString(), "broadcast");
  EXPECT_STREQ(message["header"]["destination"].GetString(), "broadcast");
  EXPECT_EQ(message["payload"]["squads"].Size(), 2U);
  EXPECT_STREQ(
      message["payload"]["squads"][0]["platforms"][0]["emergency"]["safe_command"].GetString(),
      "go_home");
}

TEST_F(Soar, HearsTheAnswerOfAShortNameOnItsOwnTopic) {
  const auto engine = Simulate({"autonomy_engine"});
  operator_.home().Write("squads.toml", kSquads);
  const Finished run = Fleetpub({"soar", "planning-configuration", "autonomy_engine", "--file",
                                 operator_.home() / "squads.toml", "--source", "ui", "--wait"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("autonomy_engine: executed"));
}

TEST_F(Soar, HearsAcknowledgementsWhereItIsTold) {
  const Subscriber subscriber(broker_, "soar/#");
  Process waiting(operator_.Prepare(Plan("ah1", {"--wait", "--ack-topic", "fleet.+.acks"})));
  const auto received = subscriber.Await(1);
  ASSERT_THAT(received, SizeIs(1));
  EXPECT_EQ(received[0].topic, "soar/ah1");
  Say("fleet/noc/acks",
      fmt::format(R"({{"payload":{{"message_type":"acknowledgement","acknowledged_message_ID":)"
                  R"("{}","status":"executed"}}}})",
                  Json(received[0].payload)["header"]["message_ID"].GetString()));
  EXPECT_EQ(waiting.Wait(), 0) << waiting.Errors();
  EXPECT_THAT(waiting.Errors(), HasSubstr("ah1: executed"));
}

TEST_F(Soar, AcknowledgesByHand) {
  const Subscriber subscriber(broker_, "soar/#");
  Process waiting(operator_.Prepare(Plan(kEco1, {"--wait"})));
  const auto plan = subscriber.Await(1);
  ASSERT_THAT(plan, SizeIs(1));
  const Finished run =
      Fleetpub({"soar", "acknowledge", kEco1, "--message-id",
                Json(plan[0].payload)["header"]["message_ID"].GetString(), "--status", "executed"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(subscriber.Await(2)[1].topic,
            "soar/planet-ocean/ecosub/eco1/from_platform/acknowledgement");
  EXPECT_EQ(waiting.Wait(), 0);
}

TEST_F(Soar, ReportsObservationsAndStatuses) {
  const Subscriber subscriber(broker_, "soar/#");
  operator_.home().Write("region.json", R"({"type":"Point","coordinates":[-4.19,50.37]})");
  EXPECT_EQ(Fleetpub({"soar", "observation", kEco1, "--platform-id", "2", "--point",
                      "lat=50.37,lon=-4.19,quality=0.98", "--point", "lat=50.36,lon=-4.2",
                      "--region-surveyed", "@" + (operator_.home() / "region.json").string(),
                      "--additional-data", "null"})
                .exit_code,
            0);
  EXPECT_EQ(Fleetpub({"soar", "platform-status", kEco1, "--platform_ID", "2", "--status-source",
                      "usbl", "--latitude", "50.37", "--longitude", "-4.19", "--battery", "80.5",
                      "--sensor-on", "true"})
                .exit_code,
            0);
  const auto received = subscriber.Await(2);
  ASSERT_THAT(received, SizeIs(2));
  EXPECT_THAT(received[0].payload,
              HasSubstr(R"("points_of_interest":[{"latitude":50.37,"longitude":-4.19,)"
                        R"("quality_of_point":0.98},{"latitude":50.36,"longitude":-4.2}])"));
  EXPECT_THAT(received[0].payload, HasSubstr(R"("region_surveyed":{"type":"Point")"));
  EXPECT_THAT(received[0].payload, HasSubstr(R"("additional_data":null)"));
  EXPECT_EQ(received[1].topic, "soar/planet-ocean/ecosub/eco1/from_platform/platform_status");
  EXPECT_THAT(received[1].payload, HasSubstr(R"("sensor_config":{"sensor_on":true})"));
  EXPECT_THAT(received[1].payload, HasSubstr(R"("platform_timestamp":"20)"));
}

TEST_F(Soar, StandsInTheHistoryBesideTheOtherProtocol) {
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(Fleetpub(Plan(kEco1)).exit_code, 0);
  const auto rows = Lines(Fleetpub({"history"}).output);
  ASSERT_THAT(rows, SizeIs(3));
  EXPECT_THAT(rows[1], HasSubstr("startPause"));
  EXPECT_THAT(rows[2], AllOf(HasSubstr(kEco1), HasSubstr("mission_plan"), HasSubstr("SENT")));
  const std::string one = Fleetpub({"history", "show", "2"}).output;
  EXPECT_THAT(one, HasSubstr("protocol   soar 1.0"));
  EXPECT_THAT(one, HasSubstr("\"message_type\": \"mission_plan\""));
}

TEST_F(Soar, ShowsWhatItWouldSend) {
  operator_.UseBroker("mqtt://127.0.0.1:1");
  const Finished run = Fleetpub(Plan(kEco1, {"--dry-run", "--header-version", "2.0"}));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(Json(run.output)["header"]["version"].GetDouble(), 2.0);
  EXPECT_THAT(Fleetpub({"history"}).output, HasSubstr("nothing was sent"));
}

TEST_F(Soar, WarnsOfWhatMakesNoSenseAndRefusesItWhenAsked) {
  const Subscriber subscriber(broker_);
  const auto swapped = Plan(kEco1, {"--waypoint", "lat=-178.2,lon=50.37"});
  auto strict = swapped;
  strict.emplace_back("--strict");
  const Finished refused = Fleetpub(strict);
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.errors, HasSubstr("plan[1].latitude_waypoint: -178.2 is not between"));
  const Finished warned = Fleetpub(swapped);
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_THAT(warned.errors, HasSubstr("warning: soar.planet-ocean.ecosub.eco1: plan[1]."));
  EXPECT_THAT(subscriber.Await(1), SizeIs(1)) << "of the warned one alone";
}

struct Case {
  std::vector<std::string> arguments;
  int exit_code;
  std::string sentence;
};

class SoarRefuses : public Soar {
 protected:
  ~SoarRefuses() override { EXPECT_THAT(subscriber_.SoFar(), IsEmpty()); }

  void Expect(const std::vector<Case>& cases) const {
    for (const auto& [arguments, exit_code, sentence] : cases) {
      const Finished run = Fleetpub(arguments);
      EXPECT_EQ(run.exit_code, exit_code) << sentence << "\n" << run.errors;
      EXPECT_THAT(run.errors, HasSubstr(sentence));
      EXPECT_THAT(run.output, IsEmpty()) << sentence;
    }
  }

  const Subscriber subscriber_{broker_};
};

TEST_F(SoarRefuses, WordsThatAreNotUnderstood) {
  Expect({
      {{"soar", "mission"}, 2, "there are mission-plan, "},
      {{"soar", "mission-plan"}, 2, "--waypoint"},
      {Plan(""), 2, "name a destination"},
      {Plan("soar..ecosub.eco1"), 2, "a level is empty"},
      {Plan("soar/noc/autosub/ah1"), 2, "separated by dots"},
      {Plan("soar.noc.autosub.+"), 2, "wildcards"},
      {Plan(kEco1, {"--broadcast"}), 2, "leave out the destination"},
      {Plan(kEco1, {"--prefix", "a..b"}), 2, "a level is empty"},
      {Plan(kEco1, {"--source", ""}), 2, "the source is empty"},
      {Plan(kEco1, {"--header-version", "one"}), 2, "--header-version takes a number"},
      {Plan(kEco1, {"--wait-for", "done"}), 2, "operator_approved_and_sent"},
      {Plan(kEco1, {"--acks", "2"}), 2, "need --wait"},
      {Plan(kEco1, {"--acks", "2", "--wait"}), 2, "one platform"},
      {Plan("ah1", {"--acks", "0", "--wait"}), 2, "--acks takes"},
      {Plan(kEco1, {"--wait", "--ack-topic", "a/b+"}), 2, "a wildcard is a whole level"},
      {Plan(kEco1, {"--plan", "x.csv"}), 2, "exclude each other"},
      {Plan(kEco1, {"another"}), 2, "'another'"},
      {{"soar", "planning-configuration", "autonomy_engine"}, 2, "--file"},
  });
}

TEST_F(SoarRefuses, MembersThatAreMissingOrWrong) {
  Expect({
      {{"soar", "mission-plan", kEco1, "--plan-id", "1", "--waypoint", "lat=1,lon=2"},
       2,
       "platform_ID is missing: give it with --platform-id"},
      {{"soar", "mission-plan", kEco1, "--plan-id", "1.5", "--waypoint", "lat=1,lon=2"},
       2,
       "autonomy_engine_plan_ID must be a whole number, not '1.5'"},
      {Plan(kEco1, {"--waypoint", "lat=50.37"}), 2, "waypoint 2: longitude_waypoint is missing"},
      {Plan(kEco1, {"--waypoint", "lat=50.37,lon=west"}), 2,
       "longitude_waypoint must be a number, not 'west'"},
      {{"soar", "platform-status", kEco1, "--platform-id", "2", "--status-source", "usbl",
        "--latitude", "50,37"},
       2,
       "write 50.37"},
      {Plan(kEco1, {"--waypoint", "lat=50.37,lon=1,deep=3"}), 2, "'deep' is not known here"},
      {{"soar", "acknowledge", kEco1, "--message-id", "1", "--status", "done"},
       2,
       "status must be one of c2_received"},
      {{"soar", "acknowledge", kEco1, "--message-id", "1", "--status", "executed", "--wait"},
       2,
       "--wait"},
      {{"soar", "observation", kEco1, "--platform-id", "2", "--point", "lat=1"},
       2,
       "point 1: longitude is missing"},
      {{"soar", "observation", kEco1, "--platform-id", "2", "--region-surveyed", "{"},
       2,
       "region_surveyed: not valid JSON"},
      {{"soar", "platform-status", kEco1, "--platform-id", "2", "--status-source", "me",
        "--latitude", "1", "--longitude", "2"},
       2,
       "status_source must be one of usbl, onboard_platform"},
  });
}

TEST_F(SoarRefuses, FilesThatCannotBeRead) {
  const auto& home = operator_.home();
  home.Write("ragged.csv", "lat,lon\n50.37,-4.19\n50.36\n");
  home.Write("empty.csv", "");
  home.Write("latin1.csv", "lat,lon,action\n1,2,g\xE9nial\n");
  home.Write("deep.json", std::string(100'000, '['));
  home.Write("wrong.toml", "planning_config_ID = \n");
  home.Write("few.json", R"({"planning_config_ID":1,"squads":[{"squad_ID":1}]})");
  const auto with_plan = [&](const std::string& file) {
    return std::vector<std::string>{"soar",     "mission-plan",  kEco1, "--plan-id",
                                    "1",        "--platform-id", "1",   "--plan",
                                    home / file};
  };
  const auto with_configuration = [&](const std::string& file) {
    return std::vector<std::string>{"soar", "planning-configuration", "autonomy_engine", "-f",
                                    home / file};
  };
  Expect({
      {with_plan("ragged.csv"), 3, "ragged.csv: line 3: it has 1 fields, the header has 2"},
      {with_plan("empty.csv"), 3, "empty.csv: it is empty"},
      {with_plan("latin1.csv"), 3, "line 2: it is not valid UTF-8"},
      {with_plan("deep.json"), 3, "deep.json: "},
      {with_plan("none.csv"), 8, "none.csv"},
      {with_configuration("wrong.toml"), 3, "wrong.toml: line 1: not valid TOML"},
      {with_configuration("few.json"), 3, "exclusion_zones is required but missing"},
      {with_configuration("deep.json"), 3, "deep.json: "},
  });
}

TEST_F(Soar, ValidatesMessagesOfAllTypes) {
  const std::string messages = FLEETPUB_SOURCE_DIR "/tests/data/soar/messages.json";
  std::ifstream file(messages);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto all = Json(text);
  std::string lines;
  for (const auto& member : all.GetObject()) lines += base::ToJson(member.value) + "\n";
  operator_.home().Write("lines.jsonl", lines + R"({"header":{},"payload":{"message_type":"x"}})");
  const Finished run = Fleetpub({"validate", "--protocol", "soar", "--lines", "-o", "json",
                                 operator_.home() / "lines.jsonl"});
  EXPECT_EQ(run.exit_code, 3);
  const auto results = Lines(run.output);
  ASSERT_THAT(results, SizeIs(6));
  for (int i = 0; i < 5; ++i)
    EXPECT_TRUE(Json(results[static_cast<std::size_t>(i)])["valid"].GetBool())
        << results[static_cast<std::size_t>(i)];
  EXPECT_THAT(results[5], HasSubstr("must be one of acknowledgement, mission_plan, observation, "
                                    "planning_configuration, platform_status"));
}

TEST_F(Soar, ValidatesByTypeAndAsStrictlyAsAsked) {
  const auto& home = operator_.home();
  home.Write("plan.json", R"({"message_type":"mission_plan","autonomy_engine_plan_ID":1,
                              "platform_ID":1,"plan":[]})");
  const auto validate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"validate", "--protocol", "soar", home / "plan.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Fleetpub(arguments);
  };
  EXPECT_THAT(validate({}).output, HasSubstr("header, payload are required but missing"));
  const Finished alone = validate({"--message-type", "mission_plan"});
  EXPECT_EQ(alone.exit_code, 0);
  EXPECT_THAT(alone.errors,
              HasSubstr("warning: " + (home / "plan.json").string() + ":2:47: /plan"));
  EXPECT_EQ(validate({"--message-type", "mission_plan", "--strict"}).exit_code, 3);
  EXPECT_THAT(validate({"--message-type", "observation"}).output,
              HasSubstr("/message_type: is mission_plan, not observation"));
  EXPECT_EQ(validate({"--message-type", "plan"}).exit_code, 2);
  EXPECT_EQ(validate({"--topic", "state"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"validate", "--message-type", "observation"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"validate", "--protocol", "mqtt"}).exit_code, 2);
}

TEST_F(Soar, ShowsItsSchema) {
  EXPECT_THAT(Fleetpub({"schema", "list"}).output, HasSubstr("soar/1.0/messages"));
  const Finished whole = Fleetpub({"schema", "show", "soar"});
  EXPECT_STREQ(Json(whole.output)["openapi"].GetString(), "3.0.2");
  EXPECT_EQ(Fleetpub({"schema", "show", "soar/1.0/messages"}).output, whole.output);
  const Finished part =
      Fleetpub({"schema", "show", "soar/1.0/messages#/components/schemas/acknowledgement"});
  EXPECT_EQ(Json(part.output)["required"].Size(), 3U);
  for (const char* name : {"soar#/nowhere", "soar#x", "soa"}) {
    EXPECT_EQ(Fleetpub({"schema", "show", name}).exit_code, 2) << name;
  }
}

TEST_F(Soar, SimulatesPlatformsThatSayWhereTheyAre) {
  const Subscriber subscriber(broker_, "soar/+/+/+/from_platform/platform_status");
  const auto platform = Simulate({kEco1, "--state-interval", "100ms", "-v"});
  EXPECT_THAT(platform->Errors(), HasSubstr("1 platform online at " + broker_.Url()));
  EXPECT_THAT(subscriber.Await(3), SizeIs(3));
  Say("soar/planet-ocean/ecosub/eco1/to_platform/mission_plan", R"({"header":{}})");
  EXPECT_TRUE(platform->AwaitErrors("payload is required but missing"));
  platform->Signal(SIGTERM);
  EXPECT_EQ(platform->Wait(), 0);
}

TEST_F(Soar, SimulatesPlatformsThatComeBack) {
  const auto platform = Simulate({kEco1});
  broker_.Restart();
  EXPECT_TRUE(platform->AwaitErrors("connecting again"));
  const Subscriber subscriber(broker_, "soar/+/+/+/from_platform/platform_status");
  EXPECT_THAT(subscriber.Await(1), SizeIs(1));
  const auto brief = Simulate({"ah1", "--for", "50ms"});
  EXPECT_EQ(brief->Wait(), 0);
}

TEST_F(Soar, SimulatesNothingThatMakesNoSense) {
  const std::vector<Case> cases = {
      {{"simulate", "--protocol", "soar"}, 2, "name at least one platform"},
      {{"simulate", "--protocol", "soar", "a..b"}, 2, "a level is empty"},
      {{"simulate", "--protocol", "soar", "ah1", "ah1"}, 2, "named twice"},
      {{"simulate", "--protocol", "soar", "ah1", "--fail", "pause"}, 2, "for VDA 5050"},
      {{"simulate", "--protocol", "soar", "ah1", "--stop-at", "x"}, 2, "--stop-at takes"},
      {{"simulate", "--protocol", "mqtt", "ah1"}, 2, "--protocol takes"},
      {{"simulate", "KIT/1", "--stop-at", "executed"}, 2, "--stop-at belongs to"},
      {{"simulate", "--protocol", "soar", "ah1", "-b", "mqtt://127.0.0.1:1", "--connect-timeout",
        "200ms"},
       4,
       "127.0.0.1:1"},
  };
  for (const auto& [arguments, exit_code, sentence] : cases) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << sentence << "\n" << run.errors;
    EXPECT_THAT(run.errors, HasSubstr(sentence));
  }
}

}  // namespace
}  // namespace fleetpub::testing
