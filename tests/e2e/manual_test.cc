// Holds the manual to the program, and the program to the manual.
#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Manual() {
  std::ifstream file(FLEETPUB_SOURCE_DIR "/docs/manual.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
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
  for (const char* command : {"action", "actions", "await", "batch", "fleet", "history", "ping",
                              "publish", "requests", "respond", "simulate", "validate", "watch"}) {
    text += Help({command});
  }
  text += Help({"history", "show"}) + Help({"history", "prune"});
  text += Help({"config", "show"}) + Help({"config", "init"});
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
  options.merge(Matches(Help({"initPosition"}), std::regex("(--[a-z-]+)")));
  options.insert({"--lastNodeId", "--older-than"});
  for (const std::string& option : Matches(Manual(), std::regex("`(--[a-z][a-zA-Z-]*)[` ]"))) {
    EXPECT_THAT(options, Contains(option));
  }
}

TEST(TheManual, DocumentsEveryVariable) {
  const std::string manual = Manual();
  std::set<std::string> variables;
  for (const char* file :
       {"global_options.cc", "vda_options.cc", "sending.cc", "password.cc", "soar_options.cc"}) {
    std::ifstream source(std::string(FLEETPUB_SOURCE_DIR "/src/cli/") + file);
    std::ostringstream text;
    text << source.rdbuf();
    variables.merge(Matches(text.str(), std::regex("\"(FLEETPUB_[A-Z_]+)\"")));
  }
  EXPECT_GT(variables.size(), 15U);
  for (const std::string& variable : variables) {
    EXPECT_NE(manual.find("`" + variable + "`"), std::string::npos) << variable;
  }
}

}  // namespace
}  // namespace fleetpub::testing
