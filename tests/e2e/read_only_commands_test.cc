// The commands that send nothing: catalogue, schemas, validation, history, ping, help.
#include <gmock/gmock.h>

#include <fstream>

#include "support/broken_broker.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

class ReadOnlyCommands : public EndToEnd {};

TEST_F(ReadOnlyCommands, EndWithAnObjectWhenJsonIsAsked) {
  const std::pair<std::vector<std::string>, int> cases[] = {
      {{"fleet", "-o", "json", "-b", "mqtt://127.0.0.1:1"}, 4},
      {{"history", "--output=json", "--since", "soon"}, 2},
      {{"history", "--no-such-option", "-o", "json"}, 2},
      {{"show-me", "-ojson"}, 2},
      {{"history", "show", "7", "-o", "json"}, 2},
      {{"await", "KIT/0001", "state", "pausd=true", "-o", "json"}, 2},
  };
  for (const auto& [words, exit_code] : cases) {
    const Finished run = Fleetpub(words);
    EXPECT_EQ(run.exit_code, exit_code) << run.errors;
    const auto lines = Lines(run.output);
    ASSERT_THAT(lines, SizeIs(1)) << words.front();
    const auto error = Json(lines[0]);
    EXPECT_EQ(error["error"]["exitCode"].GetInt(), exit_code);
    EXPECT_THAT(run.errors, HasSubstr(error["error"]["message"].GetString()));
  }
}

TEST_F(ReadOnlyCommands, ShowTheWholeHistoryToAScript) {
  std::string lines;
  for (int i = 0; i < 60; ++i)
    lines += R"({"target":"KIT/0001","action":"startPause"})"
             "\n";
  Command batch = operator_.Prepare({"batch", "--vda", "3.0"});
  batch.input = lines;
  EXPECT_EQ(::fleetpub::testing::Run(std::move(batch)).exit_code, 0);
  EXPECT_THAT(Lines(Fleetpub({"history", "-o", "json"}).output), SizeIs(60));
  const auto some = Lines(Fleetpub({"history", "--limit", "2", "-o", "json"}).output);
  ASSERT_THAT(some, SizeIs(2));
  EXPECT_TRUE(Json(some[1])["payload"]["actions"].IsArray());
}

TEST_F(ReadOnlyCommands, WhatFollowsTwoDashesIsNoOption) {
  const Finished pause =
      Fleetpub({"pause", "--dry-run", "--offline", "--vda", "2.1", "--", "-x/1", "--all/2"});
  EXPECT_EQ(pause.exit_code, 0) << pause.errors;
  ASSERT_THAT(Lines(pause.output), SizeIs(2));
  EXPECT_STREQ(Json(Lines(pause.output)[0])["manufacturer"].GetString(), "-x");
  EXPECT_STREQ(Json(Lines(pause.output)[1])["manufacturer"].GetString(), "--all");
  EXPECT_EQ(Fleetpub({"pause", "--dry-run", "--", "KIT/0001", "--wait"}).exit_code, 2);
}

TEST_F(ReadOnlyCommands, IsStrictAboutRecommendationsToo) {
  const std::string file = operator_.home() / "m.json";
  std::ofstream(file) << R"({"headerId":0,"timestamp":"2026-01-02T03:04:05.678Z","version":"2.1.0",
      "manufacturer":"KIT","serialNumber":"0001",
      "actions":[{"actionType":"stateRequest","actionId":"{id}","blockingType":"NONE"}]})";
  EXPECT_EQ(Fleetpub({"validate", file}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"validate", "--strict", file}).exit_code, 3);
}

TEST_F(ReadOnlyCommands, ListsTheCatalogueOfAVersion) {
  EXPECT_THAT(Lines(Fleetpub({"actions", "--quiet"}).output), SizeIs(29));
  EXPECT_THAT(Lines(Fleetpub({"actions", "--vda", "1.1", "--quiet"}).output), SizeIs(13));
  const auto lines = Lines(Fleetpub({"actions", "--vda", "2.1", "-o", "json"}).output);
  ASSERT_THAT(lines, SizeIs(17));
  const auto pause = Json(lines[0]);
  EXPECT_STREQ(pause["actionType"].GetString(), "startPause");
  EXPECT_STREQ(pause["counterAction"].GetString(), "stopPause");
  EXPECT_TRUE(pause["instant"].GetBool());
}

TEST_F(ReadOnlyCommands, ValidatesWhatItBuilt) {
  for (const char* version : {"1.1", "2.0", "2.1", "3"}) {
    Command command = operator_.Prepare({"validate"});
    command.input = Send({"pause", "KIT/0001", "--vda", version, "-n"}).output;
    const Finished run = testing::Run(command);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    EXPECT_EQ(run.output, "standard input: valid\n");
  }
}

TEST_F(ReadOnlyCommands, TellsTheTopicFromTheMessage) {
  const std::pair<const char*, const char*> table[] = {
      {R"("version":"3.0.0","nodes":[])", "orderId, orderUpdateId, edges are required"},
      {R"("version":"2.1.0","agvPosition":{},"operatingMode":"MANUAL")", "lastNodeId"},
      {R"("version":"2.0.0","velocity":{})",
       "serialNumber are required but missing; a correction of ours"},
      {R"("version":"2.0.0","protocolLimits":{})", "agvGeometry"},
      {R"("version":"3.0.0","responses":[{}])", "requestId, grantType are required"},
      {R"("version":"3.0.0","zoneSet":{})", "/zoneSet: mapId, zoneSetId, zones are required"},
      {R"("version":"3.0.0","note":1)", "name it with --topic"},
  };
  for (const auto& [members, complaint] : table) {
    Command command = operator_.Prepare({"validate"});
    command.input = "{" + std::string(members) + "}";
    const Finished run = testing::Run(command);
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_THAT(run.output, HasSubstr(complaint)) << members;
  }
}

TEST_F(ReadOnlyCommands, PutsSchemasOfAFolderBeforeItsOwn) {
  operator_.home().Write("published/3.0/order.schema", R"({"required":["mine"]})");
  operator_.home().Write("published/3.0/state.schema", "{\n  \"type\": \"object\",\n}");
  const auto folder = (operator_.home() / "published").string();
  const auto validate = [&](const char* topic) {
    Command command =
        operator_.Prepare({"validate", "--schema-dir", folder, "--vda", "3", "--topic", topic});
    command.input = "{}";
    return testing::Run(command);
  };
  EXPECT_EQ(validate("order").output, "standard input:1:1: mine is required but missing\n");
  EXPECT_THAT(validate("visualization").output, HasSubstr("referenceStateHeaderId"));
  EXPECT_THAT(validate("state").errors,
              HasSubstr("published/3.0/state.schema: not valid JSON at line 3, column 1"));
  const Finished show = Fleetpub({"schema", "show", "vda5050/3.0.0/state", "--schema-dir", folder});
  EXPECT_THAT(show.errors, HasSubstr("state.schema: not valid JSON at line 3, column 1"));
  const Finished pause = Send({"pause", "KIT/0001", "-n", "--schema-dir", folder + "/3.0"});
  EXPECT_EQ(pause.exit_code, 0) << pause.errors;
}

TEST_F(ReadOnlyCommands, ListsEveryViolationWithItsPlace) {
  const auto file = operator_.home().Write(
      "message.json", R"({"headerId":-1,"timestamp":"2023-02-29T00:00:00Z","version":"3.0.0",)"
                      R"("manufacturer":"KIT","actions":[{"actionType":"a","actionId":1}]})");
  const Finished run = Fleetpub({"validate", file.string(), "-o", "json"});
  EXPECT_EQ(run.exit_code, 3);
  const auto result = Json(run.output);
  EXPECT_FALSE(result["valid"].GetBool());
  std::vector<std::string> paths;
  for (const auto& error : result["errors"].GetArray())
    paths.emplace_back(error["path"].GetString());
  EXPECT_THAT(paths, ::testing::UnorderedElementsAre("", "/headerId", "/timestamp", "/actions/0",
                                                     "/actions/0/actionId"));
}

TEST_F(ReadOnlyCommands, WarnsOfTheTextsRulesAndFailsOnThemWhenStrict) {
  const auto file = operator_.home().Write(
      "message.json", R"({"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
                      R"("manufacturer":"KIT","serialNumber":"1","actions":[]})");
  const Finished lenient = Fleetpub({"validate", file.string()});
  EXPECT_EQ(lenient.exit_code, 0);
  EXPECT_THAT(lenient.errors, HasSubstr("at least one action"));
  EXPECT_EQ(Fleetpub({"validate", file.string(), "--strict"}).exit_code, 3);
}

TEST_F(ReadOnlyCommands, ValidatesLinesWithTheirNumbers) {
  const std::string good = Send({"pause", "KIT/0001", "-n"}).output;
  const auto file = operator_.home().Write("messages.jsonl", good + "\n{\"a\":\n" + good);
  const Finished run = Fleetpub({"validate", "--lines", file.string(), "-o", "json"});
  EXPECT_EQ(run.exit_code, 3);
  const auto lines = Lines(run.output);
  ASSERT_THAT(lines, SizeIs(3));
  EXPECT_EQ(Json(lines[1])["line"].GetInt(), 3);
  EXPECT_FALSE(Json(lines[1])["valid"].GetBool());
}

TEST_F(ReadOnlyCommands, ValidatesFilesAndFolders) {
  const auto& home = operator_.home();
  const std::string good = Send({"pause", "KIT/0001", "-n"}).output;
  home.Write("orders/a/good.json", good);
  home.Write("orders/bad.json", "{\n  \"version\": \"3.0.0\",\n  \"nodes\": 1\n}\n");
  home.Write("orders/broken.json", "{\n  \"version\":,\n}");
  home.Write("orders/many.jsonl", good + good);
  home.Write("orders/.git/x.json", "no message");
  home.Write("orders/readme.txt", "no message");
  const std::string folder = home / "orders";
  const Finished run = Fleetpub({"validate", folder});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("a/good.json: valid\n"), HasSubstr("bad.json:3:3: /nodes: "),
                    HasSubstr("broken.json:2:13: not valid JSON"), HasSubstr("many.jsonl:2: valid"),
                    HasSubstr("\n4 files: 3 valid, 2 invalid\n")));
  EXPECT_THAT(run.output, Not(HasSubstr(".git")));
  const auto lines = Lines(Fleetpub({"validate", folder + "/bad.json", "-o", "json"}).output);
  ASSERT_THAT(lines, SizeIs(1));
  const auto bad = Json(lines[0]);
  EXPECT_EQ(bad["file"].GetString(), folder + "/bad.json");
  EXPECT_EQ(bad["errors"][0]["line"].GetInt(), 1) << "what is missing, is missing in all of it";
  const Finished some =
      Fleetpub({"validate", folder + "/a/good.json", folder + "/none.json", "-o", "json"});
  EXPECT_EQ(some.exit_code, 8);
  EXPECT_EQ(Json(Lines(some.output).back())["summary"]["valid"].GetInt(), 1);
}

TEST_F(ReadOnlyCommands, TakesNoEmptyInputForValid) {
  operator_.home().Write("folder/readme.txt", "no message");
  const auto empty = operator_.home().Write("empty.jsonl", "\n\n").string();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"validate"},
        {"validate", "--lines"},
        {"validate", empty},
        {"validate", (operator_.home() / "folder").string()}}) {
    EXPECT_EQ(Fleetpub(words).exit_code, 3) << words.back();
  }
  EXPECT_EQ(Fleetpub({"validate", (operator_.home() / "none").string()}).exit_code, 8);
}

TEST_F(ReadOnlyCommands, ValidatesAMessageWhoseHeaderIsStillToCome) {
  const auto body = operator_.home().Write(
      "body.json", R"({"actions":[{"actionType":"startPause","actionId":"1",)"
                   R"("blockingType":"NONE"}]})");
  const std::string file = body.string();
  EXPECT_EQ(Fleetpub({"validate", file, "--vda", "3"}).exit_code, 3);
  EXPECT_EQ(Fleetpub({"validate", file, "--vda", "3", "--body"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"validate", file, "--body"}).exit_code, 3) << "of which version?";
  const auto wrong = operator_.home().Write("wrong.json", R"({"headerId":"x","actions":[]})");
  EXPECT_THAT(Fleetpub({"validate", wrong.string(), "--vda", "3", "--body"}).output,
              HasSubstr("/headerId"));
  EXPECT_EQ(Fleetpub({"validate", file, "--body", "--protocol", "soar"}).exit_code, 2);
}

TEST_F(ReadOnlyCommands, SurvivesHostileMessagesAndSchemas) {
  const std::vector<std::string> messages = {
      std::string(1'000'000, '['), "\xFF", "", std::string("{}\0{}", 5),
      R"({"a":1,"a":2})",          "1e999"};
  for (const std::string& message : messages) {
    Command command = operator_.Prepare({"validate"});
    command.input = message;
    EXPECT_EQ(testing::Run(command).exit_code, 3) << message.substr(0, 20);
  }
  for (const std::string schema : {R"({"$ref":"#"})", R"({"multipleOf":0})", R"({"type":"strnig"})",
                                   R"({"pattern":"("})", R"({"unevaluatedItems":false})", "{,}"}) {
    const auto file = operator_.home().Write("schema.json", schema);
    Command command = operator_.Prepare({"validate", "--schema", file.string()});
    command.input = "{}";
    const Finished run = testing::Run(command);
    EXPECT_EQ(run.exit_code, 3) << schema << run.errors;
    EXPECT_THAT(run.errors, HasSubstr("schema.json"));
  }
}

TEST_F(ReadOnlyCommands, ShowsAndListsSchemas) {
  EXPECT_THAT(Fleetpub({"schema", "list"}).output, HasSubstr("vda5050/3.0.0/instantActions"));
  const Finished run = Fleetpub({"schema", "show", "vda5050/3.0.0/instantActions"});
  EXPECT_TRUE(Json(run.output).HasMember("$comment"));
  const Finished wrong = Fleetpub({"schema", "show", "vda5050/3.0.0/instantaction"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("did you mean vda5050/3.0.0/instantActions?"));
}

TEST_F(ReadOnlyCommands, PrintsResultsForPipelines) {
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"pause", "KIT/0001", "KIT/0002", "-o"};
    words.insert(words.end(), more.begin(), more.end());
    return Send(std::move(words));
  };
  EXPECT_EQ(run({"csv", "--fields", "target,status,actions.0.type"}).output,
            "target,status,actions.0.type\nKIT/0001,SENT,startPause\nKIT/0002,SENT,startPause\n");
  const auto tsv = Lines(run({"tsv"}).output);
  ASSERT_THAT(tsv, SizeIs(3));
  EXPECT_THAT(tsv[0], HasSubstr("target\tprotocol\tversion\ttopic\tactions"));
  EXPECT_EQ(run({"template={target} {status}"}).output, "KIT/0001 SENT\nKIT/0002 SENT\n");
  const auto json = Lines(run({"json", "--fields", "headerId"}).output);
  ASSERT_THAT(json, SizeIs(2));
  EXPECT_EQ(Json(json[0]).MemberCount(), 1U);
  for (const auto& wrong : std::vector<std::vector<std::string>>{{"csv", "--fields", "targt"},
                                                                 {"text", "--fields", "target"},
                                                                 {"template={x"},
                                                                 {"xml"}}) {
    EXPECT_EQ(run(wrong).exit_code, 2) << wrong[0];
  }
  EXPECT_THAT(Lines(Fleetpub({"history", "-o", "csv", "--fields", "id"}).output), SizeIs(9))
      << "nothing was sent for what was refused";
  EXPECT_EQ(Fleetpub({"history", "show", "99", "-o", "csv"}).output, "") << "errors are no rows";
}

TEST_F(ReadOnlyCommands, DescribesItsOwnOutputAndConfiguration) {
  EXPECT_STREQ(Json(Fleetpub({"schema", "show", "output/result"}).output)["title"].GetString(),
               "result");
  EXPECT_STREQ(Json(Fleetpub({"schema", "show", "config"}).output)["title"].GetString(),
               "config.toml");
  EXPECT_THAT(Fleetpub({"schema", "list"}).output, HasSubstr("fleetpub/output/result"));
}

TEST_F(ReadOnlyCommands, RemembersWhatWasSent) {
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(Send({"resume", "KIT/0002", "-q", "1"}).exit_code, 0);
  EXPECT_EQ(Send({"resume", "KIT/0003", "--no-history"}).exit_code, 0);
  const auto rows = Lines(Fleetpub({"history", "-o", "json"}).output);
  ASSERT_THAT(rows, SizeIs(2));
  EXPECT_STREQ(Json(rows[0])["status"].GetString(), "SENT");
  EXPECT_STREQ(Json(rows[1])["status"].GetString(), "PUBLISHED");
  EXPECT_EQ(std::string(Json(rows[1])["broker"].GetString()), broker_.Url());
  EXPECT_THAT(Lines(Fleetpub({"history", "--target", "KIT/0002", "--quiet"}).output), SizeIs(1));
  EXPECT_THAT(Fleetpub({"history", "show", "2"}).output,
              AllOf(HasSubstr("KIT/0002"), HasSubstr("\"actionType\": \"stopPause\"")));
  EXPECT_EQ(Fleetpub({"history", "show", "3"}).exit_code, 2);
  const Finished newest = Fleetpub({"history", "--limit", "1", "-o", "json"});
  EXPECT_THAT(Lines(newest.output), SizeIs(1));
  EXPECT_THAT(newest.errors, HasSubstr("older ones are not shown"));
  EXPECT_THAT(Fleetpub({"history", "--limit", "2"}).errors, IsEmpty());
  EXPECT_EQ(Fleetpub({"history", "--status", "lost"}).exit_code, 2);
  EXPECT_THAT(Fleetpub({"history", "--ledger", "no-such.db"}).errors,
              HasSubstr("there is no ledger at no-such.db"));
  EXPECT_THAT(Fleetpub({"history", "prune", "--older-than", "0s"}).output, HasSubstr("2 rows"));
  EXPECT_EQ(Json(Send({"pause", "KIT/0001", "-o", "json"}).output)["headerId"].GetInt(), 1);
}

TEST_F(ReadOnlyCommands, FindsInTheHistoryWhoeverIsNamed) {
  operator_.home().Write(".config/fleetpub/config.toml",
                         "[robot.\"KIT/0001\"]\nalias = \"agv1\"\n"
                         "[group]\nhall-1 = [\"agv1\", \"ABC/7\"]\n");
  for (const char* robot : {"KIT/0001", "KIT/0002", "ABC/7"}) {
    EXPECT_EQ(Send({"pause", robot}).exit_code, 0);
  }
  const auto count = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "history");
    const Finished run = Fleetpub(std::move(words));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return Lines(run.output).size() - 1;  // the names of the columns
  };
  EXPECT_EQ(count({"KIT/0001"}), 1U);
  EXPECT_EQ(count({"KIT/*"}), 2U);
  EXPECT_EQ(count({"@hall-1"}), 2U);
  EXPECT_EQ(count({"agv1", "--target", "*/7"}), 2U);
  EXPECT_EQ(count({"KIT/*", "--limit", "1"}), 1U);
  EXPECT_EQ(count({"--since", "today", "--until", "23:59:59"}), 0U) << "23:59:59 was yesterday's";
  EXPECT_THAT(Fleetpub({"history", "*/*", "--limit", "2"}).errors,
              HasSubstr("older ones are not shown"));
  EXPECT_EQ(Fleetpub({"history", "@no-such"}).exit_code, 2);
  const Finished number = Fleetpub({"history", "2"});
  EXPECT_EQ(number.exit_code, 2);
  EXPECT_THAT(number.errors, HasSubstr("fleetpub history show 2"));
}

TEST_F(ReadOnlyCommands, TellsInTheHistoryWhyAndWhen) {
  EXPECT_EQ(Send({"pause", "KIT/0001"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"pause", "KIT/0002", "--vda", "3.0", "--no-check", "--wait", "-W", "50ms"})
                .exit_code,
            6);
  const auto rows = Lines(Fleetpub({"history"}).output);
  ASSERT_THAT(rows, SizeIs(3));
  EXPECT_THAT(rows[0], AllOf(HasSubstr("LOCAL TIME"), HasSubstr("REASON")));
  const std::string why =
      Json(Lines(Fleetpub({"history", "-o", "json"}).output)[1])["message"].GetString();
  EXPECT_THAT(rows[2], ::testing::EndsWith("  TIMEOUT  " + why));
  EXPECT_THAT(Fleetpub({"history", "show", "2"}).output, HasSubstr(" s ago"));
}

TEST_F(ReadOnlyCommands, PingsTheBroker) {
  const auto robot = Robot({"KIT/0001"});  // what it has left is not the broker's
  const Finished text = Fleetpub({"ping"});
  EXPECT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_THAT(text.output, AllOf(HasSubstr("reachable"), HasSubstr("mosquitto version")));
  EXPECT_EQ(Fleetpub({"ping", "--interface", "AMR"}).exit_code, 0);
  EXPECT_EQ(Fleetpub({"ping", "--interface", "A/B"}).exit_code, 2);
  EXPECT_TRUE(broker_.AwaitLog("AMR/+/+/+/factsheet"));
  EXPECT_EQ(Fleetpub({"ping", "--topic-template", "plant/{serial}/{topic}"}).exit_code, 0);
  EXPECT_TRUE(broker_.AwaitLog("plant/+/state"));
  const auto json = Json(Fleetpub({"ping", "-o", "json", "-V", "5"}).output);
  EXPECT_TRUE(json["reachable"].GetBool());
  EXPECT_STREQ(json["mqtt"].GetString(), "5");
  EXPECT_TRUE(json["subscribe"]["state"].GetBool());
  operator_.UseBroker("mqtt://127.0.0.1:1");
  EXPECT_EQ(Fleetpub({"ping"}).exit_code, 4);
}

TEST(Ping, SaysWhichSubscriptionsTheBrokerRefuses) {
  const std::string software("\x90\x03\x00\x01\x00", 5);
  const std::string granted("\x90\x03\x00\x02\x00", 5);
  const std::string refused("\x90\x03\x00\x03\x80", 5);
  const BrokenBroker broker(
      BrokenBroker::Answers({BrokenBroker::Connack(0), software, granted, refused}));
  Operator someone;
  someone.UseBroker(broker.Url());
  const Finished run = someone.Fleetpub({"ping", "-o", "json", "--connect-timeout", "500ms"});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_TRUE(Json(run.output)["subscribe"]["connection"].GetBool());
  EXPECT_FALSE(Json(run.output)["subscribe"]["state"].GetBool());
}

TEST_F(ReadOnlyCommands, ExplainsItself) {
  const Finished general = Fleetpub({"--help"});
  EXPECT_EQ(general.exit_code, 0);
  EXPECT_THAT(general.output, AllOf(HasSubstr("startPause, pause"), HasSubstr("--broker"),
                                    HasSubstr("no emergency stop")));
  const Finished command = Fleetpub({"initposition", "--help"});
  EXPECT_EQ(command.exit_code, 0);
  EXPECT_THAT(command.output, AllOf(HasSubstr("--lastNodeId,--last-node-id"), HasSubstr("Examples"),
                                    Not(HasSubstr("--cafile"))));
  for (const Finished& help : {general, command, Fleetpub({"validate", "-h"})}) {
    for (const std::string& line : Lines(help.output)) EXPECT_LE(line.size(), 80U) << line;
  }
  EXPECT_THAT(Fleetpub({"--version"}).output, ::testing::StartsWith("fleetpub "));
}

}  // namespace
}  // namespace fleetpub::testing
