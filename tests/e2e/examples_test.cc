// Every command that the manual and its sister pages show is run as it stands there, with virtual
// robots, and what they show as its output is what comes out.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "support/document.h"
#include "support/mosquitto.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

void Replace(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), with);
    at += with.size();
  }
}

/// What a chapter's commands take for granted.
struct World {
  std::string setup;  ///< shell, before the first
  /// Shell before the first command that begins so.
  std::vector<std::pair<std::string, std::string>> before = {};
  /// Other exit codes than 0, by the command's beginning.
  std::vector<std::pair<std::string, int>> codes = {};
  /// What is put in the place of something that stands in the commands.
  std::vector<std::pair<std::string, std::string>> changes = {};
};

// Shell functions for the worlds: `online TARGET…` returns when the robots are online.
constexpr const char* kPrelude = R"(
trap 'kill $(jobs -p) 2>/dev/null; wait' EXIT
shopt -s expand_aliases
background() { local log; log=$(mktemp -p .); "$@" >"$log" 2>&1 & until grep -q online "$log"; do sleep .02; done; cat "$log"; }
until_killed() { background "$@"; kill $!; wait $!; }
online() { background fleetpub simulate --state-interval 50ms "$@" >/dev/null; }
gone() { online "$@"; kill $!; wait $!; }
everybody_goes() { kill $(jobs -p); wait; }
order() { echo '{"orderId":"o-1","orderUpdateId":0,"nodes":[{"nodeId":"n1","sequenceId":0,"released":true,"actions":[],
  "nodePosition":{"x":-5,"y":5,"mapId":"map-1"}},{"nodeId":"n2","sequenceId":2,"released":true,"actions":[],
  "nodePosition":{"x":5,"y":5,"mapId":"map-1"}}],"edges":[{"edgeId":"e1","sequenceId":1,"released":true,
  "startNodeId":"n1","endNodeId":"n2","actions":[]}]}'; }
zones() { echo '{"zoneSet":{"mapId":"map-1","zoneSetId":"hall-1","zones":[{"zoneId":"gate","zoneType":"RELEASE",
  "releaseLossBehavior":"STOP","vertices":[{"x":0,"y":0},{"x":10,"y":0},{"x":10,"y":10},{"x":0,"y":10}]}]}}'; }
publish() { mosquitto_pub -p "$PORT" "$@"; }
)";

// The commands, each followed by its exit code, with what they print between marks.
std::string ScriptOf(const std::vector<Example>& examples, const World& world) {
  std::string script = std::string(kPrelude) + "exec 2>&1\n" + world.setup + "\n";
  auto before = world.before;
  for (const Example& example : examples) {
    const auto first = std::find_if(before.begin(), before.end(), [&](const auto& one) {
      return example.command.starts_with(one.first);
    });
    if (first != before.end()) {
      script += first->second + "\n";
      before.erase(first);
    }
    std::string command = example.command;
    for (const auto& [what, with] : world.changes) Replace(command, what, with);
    Replace(command, "127.0.0.1:1883", "127.0.0.1:$PORT");
    Replace(command, "localhost:1883", "127.0.0.1:$PORT");
    // What would run on is killed once it is up, and what runs in the background is waited for
    // until it is.
    const bool is_simulate = command.starts_with("fleetpub simulate");
    if (is_simulate && command.ends_with(" &")) {
      command = "background " + command.substr(0, command.size() - 2);
    } else if (is_simulate && command.find(" & ") == std::string::npos) {
      command = "until_killed " + command;
    }
    script += "echo '@@'\n" + command + "\necho \"@@exit $?\"\n";
  }
  return script;
}

std::string RunInAHome(const std::string& script, const Mosquitto& broker) {
  const TemporaryFolder home;
  const std::string folder = std::filesystem::path(Binary()).parent_path().string();
  std::string output = Run({.arguments = {"bash", "-uc", script},
                            .environment = {{"HOME", home.path().string()},
                                            {"PATH", folder + ":/usr/sbin:" + std::getenv("PATH")},
                                            {"PORT", std::to_string(broker.port())},
                                            {"XDG_CONFIG_HOME", std::nullopt},
                                            {"XDG_STATE_HOME", std::nullopt},
                                            {"FLEETPUB_CONFIG", std::nullopt},
                                            {"FLEETPUB_BROKER", broker.Url()},
                                            {"FLEETPUB_LEDGER", home / "ledger.db"}},
                            .folder = home.path().string()},
                           std::chrono::seconds(90))
                           .output;
  Replace(output, broker.Url(), "mqtt://localhost:1883");
  return output;
}

void ExpectShown(const Example& example, const std::vector<std::string>& lines) {
  if (example.shown.empty()) return;
  const std::string all = "of: " + example.command + "\nis not in step with the page:\n";
  for (const std::string& shown : example.shown) {
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                            [&](const std::string& line) { return IsShownAs(shown, line); }))
        << all << shown << "\n"
        << ::testing::PrintToString(lines);
  }
  for (const std::string& line : lines) {
    EXPECT_TRUE(std::any_of(example.shown.begin(), example.shown.end(),
                            [&](const std::string& shown) { return IsShownAs(shown, line); }))
        << all << line;
  }
}

void RunExamples(const std::vector<Example>& examples, const World& world) {
  const Mosquitto broker;
  const auto lines = Lines(RunInAHome(ScriptOf(examples, world), broker));
  auto line = lines.begin();
  for (const Example& example : examples) {
    line = std::find(line, lines.end(), "@@");
    const auto end = std::find_if(line, lines.end(), [](const std::string& one) {
      return one.find("@@exit ") != std::string::npos;
    });
    ASSERT_NE(end, lines.end()) << example.command << ::testing::PrintToString(lines);
    std::vector<std::string> output(std::next(line), end);
    if (!end->starts_with("@@")) output.push_back(end->substr(0, end->find("@@")));
    const auto code = std::find_if(world.codes.begin(), world.codes.end(), [&](const auto& one) {
      return example.command.starts_with(one.first);
    });
    EXPECT_EQ(end->substr(end->find("@@exit ") + 7),
              std::to_string(code == world.codes.end() ? 0 : code->second))
        << example.command << ::testing::PrintToString(output);
    ExpectShown(example, output);
    line = end;
  }
}

const World kTargets = {
    .setup =
        "online KIT/0001 --count 2; printf 'KIT/0001,hall 1\\nKIT/0002,hall 2\\n' > robots.csv",
    .before = {{"fleetpub pause --all --wait --timeout 3s",
                "everybody_goes; gone KIT/0005; online KIT/0001; online KIT/0002 --delay 2s\n"
                "online KIT/0003 --fail startPause; online KIT/0004 --silent"}},
    .codes = {{"fleetpub charge --all --where 'battery<20'", 7},  // none is that low
              {"fleetpub pause --all --wait --timeout 3s", 5}}};

const World kOrders = {
    .setup =
        "online KIT/0001 --count 2 --order-time 1s; order > order.json; zones > hall-1.json\n"
        "fleetpub publish zoneSet KIT/0001 -f hall-1.json --wait\n"
        "fleetpub enableZoneSet KIT/0001 --zoneSetId hall-1 --wait\n"
        "echo '{\"actions\":[{\"actionType\":\"stateRequest\",\"actionId\":\"a1\","
        "\"blockingType\":\"NONE\"}]}' > actions.json"};

const World kLooking = {
    .setup =
        "online KIT/0001; gone KIT/0002 --vda 2.1; fleetpub pause KIT/0001 --wait\n"
        "fleetpub charge KIT/0001 --wait",
    // The one that has gone would be waited for.
    .before = {
        {"fleetpub await KIT/0001 state paused=true",
         "fleetpub uncharge KIT/0001 --wait; publish -r -n -t uagv/v2/KIT/0002/connection"}}};

const World kSoar = {
    .setup =
        "background fleetpub simulate --protocol soar soar.planet-ocean.ecosub.eco1\n"
        "printf 'lat,lon,depth\\n50.37,-4.19,15\\n50.36,-4.20,15\\n' > waypoints.csv\n"
        "echo '{\"planning_config_ID\":3,\"squads\":[],\"exclusion_zones\":[]}' > squads.json\n",
    .changes = {{" ID ", " 00000000-0000-4000-8000-000000000000 "}}};

const World kLive = {
    .setup =
        "online KIT/0001; online KIT/0002\n"
        "publish -r -t vda5050/v3/KIT/0002/connection -m '{\"headerId\":3,\"timestamp\":"
        "\"2026-01-02T03:04:05.000Z\",\"version\":\"3.0.0\",\"manufacturer\":\"KIT\","
        "\"serialNumber\":\"0001\",\"connectionState\":\"ONLINE\"}'\n"
        "state=$(mosquitto_sub -p $PORT -C 1 -t vda5050/v3/KIT/0001/state)\n"
        "state=$(sed 's/\"charging\":[a-z]*/\"charging\":\"yes\"/; "
        "s/\"headerId\":[0-9]*/\"headerId\":17/' <<<\"$state\")\n"
        "{ sleep 1; publish -t vda5050/v3/KIT/0001/state -m \"$state\"; } &",
    .codes = {{"fleetpub validate --live", 3}},
    .changes = {{"--for 60s", "--for 3s"}}};

// By page and heading.
const std::map<std::string, std::map<std::string, World>>& Worlds() {
  static const std::map<std::string, std::map<std::string, World>> worlds = {
      {"docs/manual.md",
       {{"Commands", {}},
        {"Targets", kTargets},
        {"Waiting", {.setup = "online KIT/0001"}},
        {"Files", {}},
        {"Completion",
         {.setup =
              "mkdir -p ~/.local/share/bash-completion/completions ~/.config/fish/completions\n"
              "fpath=(\"\" \"$HOME\")"}},
        {"Output", {}},
        {"Orders and other messages", kOrders},
        {"Batch",
         {.setup = "online KIT/0001\n"
                   "echo '{\"target\":\"KIT/0001\",\"action\":\"startPause\"}' > commands.jsonl"}},
        {"Fleet, watch, await", kLooking},
        {"SoAR", kSoar},
        {"To try it", {}},
        {"Live", kLive},
        {"Simulate", {}},
        {"Platforms", {}}}},
      {"README.md",
       {{"Five minutes", {}},
        {"Five recipes",
         {.setup =
              "online KIT/0001; background fleetpub simulate --protocol soar soar.noc.autosub.ah1\n"
              "echo '{\"type\":\"LineString\",\"coordinates\":[[-4.18,50.37],[-4.19,50.37]]}' "
              "> route.geojson"}}}},
      {"docs/scale.md",
       {{"A hundred thousand robots: by site",
         {.setup =
              "mkdir -p ~/.config/fleetpub; printf '[profile.%s]\\nqos = 0\\n' north south west > "
              "~/.config/fleetpub/config.toml\n"
              "online KIT/0001 --for 20s; disown -a"}}}}};
  return worlds;
}

// Blocks of commands that are not for a test, and what is no command at all: by their beginning.
bool IsSomethingElse(const Block& block) {
  for (const char* beginning : {"fleetpub COMMAND", "default_profile = ", "ledger = ",
                                "planning_config_ID = ", "scripts/demo", "[Service]"}) {
    if (block.text.starts_with(beginning)) return true;
  }
  return false;
}

class Examples : public ::testing::TestWithParam<std::pair<std::string, std::string>> {};

std::vector<std::pair<std::string, std::string>> AllChapters() {
  std::vector<std::pair<std::string, std::string>> all;
  for (const auto& [page, chapters] : Worlds()) {
    for (const auto& [chapter, world] : chapters) all.emplace_back(page, chapter);
  }
  return all;
}

TEST_P(Examples, RunAndPrintWhatThePageShows) {
  const auto& [page, chapter] = GetParam();
  World world = Worlds().at(page).at(chapter);
  std::vector<Example> examples;
  for (const Block& block : IndentedBlocks(SourceText(page))) {
    if (block.text.starts_with("planning_config_ID")) {
      world.setup += "\ncat > squads.toml <<'END'\n" + block.text + "END\n";
    }
    if (block.chapter != chapter || IsSomethingElse(block)) continue;
    for (const Example& example : block.examples) {
      if (!example.command.starts_with("scripts/")) examples.push_back(example);
    }
  }
  ASSERT_FALSE(examples.empty());
  RunExamples(examples, world);
}

std::string NameOf(const ::testing::TestParamInfo<std::pair<std::string, std::string>>& info) {
  std::string name = info.param.first + "_" + info.param.second;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Of, Examples, ::testing::ValuesIn(AllChapters()), NameOf);

TEST(TheExamples, AreAllTried) {
  for (const char* page :
       {"README.md", "docs/manual.md", "docs/recipes.md", "docs/robot-words.md", "docs/security.md",
        "docs/brokers.md", "docs/scale.md", "docs/site.md", "docs/messages.md"}) {
    const auto blocks = IndentedBlocks(SourceText(page));
    for (const Block& block : blocks) {
      if (IsSomethingElse(block)) continue;
      EXPECT_FALSE(block.examples.empty()) << page << ": neither command nor known:\n"
                                           << block.text;
      const auto chapters = Worlds().find(page);
      EXPECT_TRUE(chapters != Worlds().end() && chapters->second.contains(block.chapter))
          << page << ": " << block.chapter << "\n"
          << block.text;
    }
  }
}

// ── configurations ──

TEST(TheExamples, OfConfigurationsAreRead) {
  const Operator someone;
  std::size_t count = 0;
  for (const Block& block : IndentedBlocks(SourceText("docs/manual.md"))) {
    const bool is_whole = block.text.starts_with("default_profile");
    if (!is_whole && !block.text.starts_with("ledger = ")) continue;
    ++count;
    const auto file = someone.home().Write("config.toml", block.text);
    const Finished shown = someone.Fleetpub({"config", "show", "--config", file});
    EXPECT_EQ(shown.exit_code, 0) << shown.errors;
    if (!is_whole) continue;
    // "So `fleetpub pause agv1` speaks 2.0.0 to KIT/0001"
    const Finished run = someone.Fleetpub(
        {"pause", "agv1", "--config", file, "--profile", "test", "--dry-run", "-o", "json"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr(R"("version":"2.0.0")"));
    EXPECT_THAT(run.output, HasSubstr(R"("instantActions":[)"));
  }
  EXPECT_EQ(count, 2U);
}

// ── commands within a line ──

// `fleetpub …` in running text and tables: there is such a command, and it has these options.
TEST(TheExamples, WithinALineNameCommandsAndOptionsThatThereAre) {
  const Operator someone;
  std::map<std::string, std::string> helps;
  const auto help = [&](const std::vector<std::string>& words) {
    std::string& text = helps[words.front() + (words.size() > 1 ? " " + words[1] : "")];
    if (text.empty()) {
      std::vector<std::string> arguments = words;
      arguments.emplace_back("--help");
      text = someone.Fleetpub(arguments).output;
    }
    return text;
  };
  const std::string general = someone.Fleetpub({"--help"}).output;
  const std::set<std::string> two_words = {"soar", "config", "schema", "history", "ledger"};
  const std::regex span("`fleetpub ([a-z][A-Za-z-]*)( [a-z-]+)?([^`]*)`");
  const std::regex option("(?:^| )(--?[a-zA-Z][a-zA-Z-]*)");
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FLEETPUB_SOURCE_DIR "/docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = SourceText("docs/" + entry.path().filename().string());
    for (std::sregex_iterator it(text.begin(), text.end(), span), end; it != end; ++it, ++count) {
      std::vector<std::string> words = {(*it)[1]};
      if (two_words.contains(words[0]) && (*it)[2].matched)
        words.push_back((*it)[2].str().substr(1));
      const std::string usage = help(words) + general;
      EXPECT_THAT(helps.begin()->second, HasSubstr("fleetpub"));
      EXPECT_NE(usage, general) << entry.path() << ": " << it->str();
      const std::string rest = (*it)[3];
      for (std::sregex_iterator o(rest.begin(), rest.end(), option); o != end; ++o) {
        EXPECT_THAT(usage, HasSubstr((*o)[1].str())) << entry.path() << ": " << it->str();
      }
    }
  }
  EXPECT_GT(count, 40U);
}

}  // namespace
}  // namespace fleetpub::testing
