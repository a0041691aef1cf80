// Holds the manual to the program, and the program to the manual.
#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>
#include <set>

#include "message/command_status.h"
#include "support/document.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Manual() { return SourceText("docs/manual.md"); }

/// Of the manual, from its heading to the next.
std::string Chapter(const std::string& heading) {
  const std::string manual = Manual();
  const auto begin = manual.find("\n## " + heading + "\n");
  return begin == std::string::npos ? ""
                                    : manual.substr(begin, manual.find("\n## ", begin + 1) - begin);
}

/// All that stands below a folder of the source.
std::string Source(const std::string& folder) {
  std::string text;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(
           std::filesystem::path(FLEETPUB_SOURCE_DIR) / folder)) {
    if (entry.path().extension() != ".cc" && entry.path().extension() != ".h") continue;
    text += SourceText(std::filesystem::relative(entry.path(), FLEETPUB_SOURCE_DIR).string());
  }
  return text;
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
  return text;
}

std::set<std::string> Matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) {
    found.insert((*it)[1]);
  }
  return found;
}

std::string Help(std::vector<std::string> words) {
  const Operator someone;
  words.emplace_back("--help");
  return someone.Fleetpub(words).output;
}

// Every option of every command, parameters of actions aside: those are in the command's own help.
std::set<std::string> Options() {
  std::string text = Help({}) + Help({"pause"});
  for (const char* command :
       {"action",  "actions",  "await", "batch",   "conform",  "doctor", "explain",  "fleet",
        "history", "order",    "ping",  "publish", "record",   "replay", "requests", "respond",
        "show",    "simulate", "tail",  "test",    "validate", "watch"}) {
    text += Help({command});
  }
  text += Help({"history", "show"}) + Help({"history", "prune"});
  text += Help({"config", "show"}) + Help({"config", "init"});
  for (const char* command : {"check", "show", "route"}) text += Help({"layout", command});
  for (const char* command : {"extend", "follow", "release", "replace"}) {
    text += Help({"order", command});
  }
  text += Help({"schema", "list"}) + Help({"schema", "show"});
  for (const char* command : {"mission-plan", "planning-configuration", "acknowledge",
                              "observation", "platform-status"}) {
    text += Help({"soar", command});
  }
  const std::regex line("(?:^|\n)  ((?:-[a-zA-Z],)?--[a-z-]+)");
  std::set<std::string> options;
  for (const std::string& names : Matches(text, line)) {
    options.merge(Matches(names, std::regex("(--?[a-zA-Z][a-z-]*)")));
  }
  return options;
}

// docs/manual.md is the manual pages' one source (scripts/man).
TEST(TheManualPages, HoldEveryChapterAndAreWellFormed) {
  const TemporaryFolder folder;
  const Finished made = fleetpub::testing::Run(
      {.arguments = {FLEETPUB_SOURCE_DIR "/scripts/man", folder.path().string()}});
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_EQ(made.errors, "");
  const Finished shown =
      fleetpub::testing::Run({.arguments = {"sh", "-c",
                                            "groff -k -man -Tutf8 -ww -P-cbou -rLL=200n '" +
                                                folder.path().string() + "'/man*/*"}});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_EQ(shown.errors, "");
  for (const std::string& chapter : Matches(Manual(), std::regex("\n## ([^\n]*)"))) {
    EXPECT_THAT(shown.output, HasSubstr("\n" + Upper(chapter) + "\n"));
  }
  for (const std::string& option : Options()) EXPECT_THAT(shown.output, HasSubstr(option));
  EXPECT_THAT(shown.output, Not(HasSubstr("](")));
}

TEST(TheManual, DocumentsEveryOption) {
  const auto documented = Matches(Manual(), std::regex("`(--?[a-zA-Z][a-z-]*)[` ]"));
  const auto options = Options();
  EXPECT_GT(options.size(), 50U);
  for (const std::string& option : options) EXPECT_THAT(documented, Contains(option));
}

TEST(TheManual, DocumentsNoOptionThatIsNotThere) {
  auto options = Options();
  options.merge(Matches(Help({"initPosition"}) + Help({"cancel"}), std::regex("(--[a-z-]+)")));
  options.insert({"--lastNodeId", "--older-than"});
  for (const std::string& option : Matches(Manual(), std::regex("`(--[a-z][a-zA-Z-]*)[` ]"))) {
    EXPECT_THAT(options, Contains(option));
  }
}

TEST(TheManual, DocumentsEveryVariableAndNoOther) {
  const std::string manual = Manual();
  const std::string source = Source("src");
  auto variables = Matches(source, std::regex("\"(FLEETPUB_[A-Z_]+)\""));
  EXPECT_GT(variables.size(), 25U);
  for (const std::string& variable : Matches(manual, std::regex("`(FLEETPUB_[A-Z_]+)`"))) {
    EXPECT_THAT(variables, Contains(variable));
  }
  variables.merge(Matches(source, std::regex("(?:getenv|FromEnvironment)\\(\"([A-Z_]+)\"\\)")));
  EXPECT_THAT(variables, Contains("XDG_STATE_HOME"));
  for (const std::string& variable : variables) {
    EXPECT_THAT(manual, HasSubstr("`" + variable + "`"));
  }
}

TEST(TheManual, DocumentsEveryExitCodeAndNoOther) {
  const std::set<std::string> codes =
      Matches(SourceText("src/cli/output/exit_code.h"), std::regex("\n  k[A-Za-z]+ = ([0-9]+),"));
  EXPECT_EQ(codes.size(), 11U);
  const std::string chapter = Chapter("Exit codes");
  std::set<std::string> documented;
  for (const std::string& row : Matches(chapter, std::regex("\n\\| ([0-9, ]+) \\|"))) {
    documented.merge(Matches(row, std::regex("([0-9]+)")));
  }
  EXPECT_EQ(documented, codes);
}

TEST(TheManual, DocumentsEveryStatusAndNoOther) {
  std::set<std::string> statuses;
  for (const auto& facts : message::kCommandStatuses) statuses.emplace(facts.name);
  EXPECT_EQ(statuses.size(), 16U);
  EXPECT_EQ(Matches(Chapter("JSON"), std::regex("\n\\| `([A-Z_]+)` \\|")), statuses);
}

// The members of the objects that `-o json` prints stand in cli's texts.
TEST(TheManual, DocumentsEveryJsonFieldAndNoOther) {
  const std::string manual = Manual();
  const std::string source = Source("src/cli");
  auto fields = Matches(source, std::regex("\"([A-Za-z]+)\\\\?\":"));
  fields.merge(Matches(source, std::regex("add\\(\"([A-Za-z]+)\"")));
  fields.merge(Matches(source, std::regex("Put[A-Za-z]*\\(json, \"([A-Za-z]+)\"")));
  EXPECT_GT(fields.size(), 70U);
  for (const std::string& field : fields) {
    EXPECT_THAT(manual, AnyOf(HasSubstr("`" + field + "`"), HasSubstr("\"" + field + "\"")))
        << field;
  }
  // The first cells of the tables of fields.
  for (const std::string& table :
       Matches(manual, std::regex("\n\\| field \\| meaning \\|\n((?:\\|[^\n]*\n)*)"))) {
    for (const std::string& cell : Matches("\n" + table, std::regex("\n\\| ([^|]*) \\|"))) {
      for (const std::string& field : Matches(cell, std::regex("`([A-Za-z]+)`"))) {
        EXPECT_THAT(fields, Contains(field));
      }
    }
  }
}

// By where they lie on the system.
TEST(TheManual, DocumentsEveryFileAndNoOther) {
  const std::string manual = Manual();
  const std::string source = Source("src");
  const auto files = Matches(source, std::regex("\"(/(?:etc|var|usr)/[^\"]*)\""));
  EXPECT_THAT(files, Contains("/var/lib/fleetpub/ledger.db"));
  for (const std::string& file : files) EXPECT_THAT(manual, HasSubstr(file));
  for (const std::string& file : Matches(manual, std::regex("`(/(?:etc|var)/[^` ]*)`"))) {
    EXPECT_THAT(source, HasSubstr(file));
  }
  for (const char* ending : {"-wal", "-shm", ".locks"}) {
    EXPECT_THAT(manual, HasSubstr("`ledger.db" + std::string(ending) + "`"));
  }
}

}  // namespace
}  // namespace fleetpub::testing
