// Every command that the manual and its sister pages show is run as it stands there, with virtual
// robots, and what they show as its output is what comes out.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "support/document.h"
#include "support/free_port.h"
#include "support/mosquitto.h"
#include "support/operator.h"
#include "support/page_world.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

void Replace(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), with);
    at += with.size();
  }
}

// The commands, each followed by its exit code, with what they print between marks.
std::string MakeScript(const std::vector<Example>& examples, const World& world) {
  std::string script = std::string(WorldFunctions()) + "exec 2>&1\n" + world.setup + "\n";
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
    Replace(command, "localhost:1884", "localhost:$PORT_1884");
    Replace(command, "localhost:8883", "localhost:$PORT_8883");
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
  const std::string port = std::to_string(broker.port());
  const std::string port_1884 = std::to_string(FreePort());
  const std::string port_8883 = std::to_string(FreePort());
  const std::string folder = std::filesystem::path(Binary()).parent_path().string();
  std::string output = Run({.arguments = {"bash", "-uc", script},
                            .environment = {{"HOME", home.path().string()},
                                            {"PATH", folder + ":/usr/sbin:" + std::getenv("PATH")},
                                            {"PORT", port},
                                            {"PORT_1884", port_1884},
                                            {"PORT_8883", port_8883},
                                            {"XDG_CONFIG_HOME", std::nullopt},
                                            {"XDG_STATE_HOME", std::nullopt},
                                            {"FLEETPUB_CONFIG", std::nullopt},
                                            {"FLEETPUB_BROKER", broker.Url()},
                                            {"FLEETPUB_LEDGER", home / "ledger.db"}},
                            .folder = home.path().string()},
                           std::chrono::seconds(90))
                           .output;
  Replace(output, "127.0.0.1:" + port, "localhost:1883");
  Replace(output, "localhost:" + port_1884, "localhost:1884");
  Replace(output, "localhost:" + port_8883, "localhost:8883");
  Replace(output, home.path().string(), "/home/ann");
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

// "The robot is offline (exit 7)"
int FindExitCode(const std::string& heading) {
  static const std::regex code(R"(.*\(exit ([0-9]+)\))");
  std::smatch match;
  return std::regex_match(heading, match, code) ? std::stoi(match[1]) : 0;
}

void RunExamples(const std::vector<Example>& examples, const World& world, int exit_code) {
  const Mosquitto broker;
  const auto lines = Lines(RunInAHome(MakeScript(examples, world), broker));
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
              std::to_string(code == world.codes.end() ? exit_code : code->second))
        << example.command << ::testing::PrintToString(output);
    ExpectShown(example, output);
    line = end;
  }
}

// Blocks of commands that are not for a test, and what is no command at all: by their beginning.
bool IsConfiguration(const Block& block) {
  return block.text.starts_with("default_profile = ") || block.text.starts_with("ledger = ") ||
         block.text.starts_with("[profile.");
}

bool IsSomethingElse(const Block& block) {
  for (const char* beginning : {"fleetpub COMMAND", "planning_config_ID = ", "problem  ",
                                "scripts/demo", "sudo apt", "[Service]"}) {
    if (block.text.starts_with(beginning)) return true;
  }
  return IsConfiguration(block);
}

constexpr const char* kPages[] = {
    "README.md",           "docs/manual.md",   "docs/recipes.md",
    "docs/robot-words.md", "docs/security.md", "docs/brokers.md",
    "docs/scale.md",       "docs/site.md",     "docs/troubleshooting.md"};

/// By chapter.
std::map<std::string, std::vector<Example>> ReadExamples(const std::string& page) {
  std::map<std::string, std::vector<Example>> examples;
  for (const Block& block : IndentedBlocks(SourceText(page))) {
    if (IsSomethingElse(block)) continue;
    for (const Example& example : block.examples) {
      if (!example.command.starts_with("scripts/")) examples[block.chapter].push_back(example);
    }
  }
  return examples;
}

World MakeWorld(const std::string& page, const std::string& chapter) {
  const auto chapters = Worlds().find(page);
  if (chapters == Worlds().end()) return {};
  const auto world = chapters->second.find(chapter);
  return world == chapters->second.end() ? World{} : world->second;
}

class DocsExamples : public ::testing::TestWithParam<std::pair<std::string, std::string>> {};

std::vector<std::pair<std::string, std::string>> AllChapters() {
  std::vector<std::pair<std::string, std::string>> all;
  for (const char* page : kPages) {
    for (const auto& [chapter, examples] : ReadExamples(page)) all.emplace_back(page, chapter);
  }
  return all;
}

TEST_P(DocsExamples, RunAndPrintWhatThePageShows) {
  const auto& [page, chapter] = GetParam();
  World world = MakeWorld(page, chapter);
  for (const Block& block : IndentedBlocks(SourceText(page))) {
    if (!block.text.starts_with("planning_config_ID")) continue;
    world.setup += "\ncat > squads.toml <<'END'\n" + block.text + "END\n";
  }
  RunExamples(ReadExamples(page).at(chapter), world, FindExitCode(chapter));
}

std::string GetName(const ::testing::TestParamInfo<std::pair<std::string, std::string>>& info) {
  std::string name = info.param.first + "_" + info.param.second;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Of, DocsExamples, ::testing::ValuesIn(AllChapters()), GetName);

TEST(DocsPages, AreAllTried) {
  for (const char* page : kPages) {
    for (const Block& block : IndentedBlocks(SourceText(page))) {
      EXPECT_TRUE(IsSomethingElse(block) || !block.examples.empty())
          << page << ": neither command nor known:\n"
          << block.text;
    }
  }
  for (const auto& [page, chapters] : Worlds()) {
    const auto examples = ReadExamples(page);
    for (const auto& [chapter, world] : chapters) {
      EXPECT_TRUE(examples.contains(chapter)) << page << " has no examples in " << chapter;
    }
  }
}

// ── configurations ──

TEST(DocsPages, OfConfigurationsAreRead) {
  const Operator someone;
  std::size_t count = 0;
  std::vector<Block> blocks = IndentedBlocks(SourceText("docs/manual.md"));
  for (Block& block : IndentedBlocks(SourceText("docs/brokers.md"))) {
    blocks.push_back(std::move(block));
  }
  for (const Block& block : blocks) {
    if (!IsConfiguration(block)) continue;
    const bool is_whole = block.text.starts_with("default_profile");
    ++count;
    const auto file = someone.home().Write("config.toml", block.text);
    const Finished shown = someone.Fleetpub({"config", "show", "--config", file});
    EXPECT_EQ(shown.exit_code, 0) << shown.errors;
    if (!is_whole) continue;
    // "So `fleetpub pause agv1` speaks 2.0.0 to KIT/0001"
    const Finished run = someone.Fleetpub({"pause", "agv1", "--config", file, "--profile", "test",
                                           "--dry-run", "--offline", "-o", "json"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr(R"("version":"2.0.0")"));
    EXPECT_THAT(run.output, HasSubstr(R"("instantActions":[)"));
  }
  EXPECT_EQ(count, 6U);
}

// ── commands within a line ──

// `fleetpub …` in running text and tables: there is such a command, and it has these options.
TEST(DocsPages, WithinALineNameCommandsAndOptionsThatThereAre) {
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
