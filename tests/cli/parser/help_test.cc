#include "cli/parser/help.h"

#include <gmock/gmock.h>

#include <regex>

#include "base/text.h"
#include "base/width.h"
#include "cli/parser/command_line.h"
#include "support/suggestions.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> AllCommands() {
  std::vector<std::string> names;
  for (const Subcommand& subcommand : Subcommands()) names.emplace_back(subcommand.name);
  for (const std::string_view word : vda5050::AllActionWords()) names.emplace_back(word);
  return names;
}

struct Helps {
  std::string brief;
  std::string whole;
};

Helps Explain(const std::string& command) {
  CommandLine call;
  EXPECT_TRUE(call.Read(OptionSet::Extent::kAll, base::Split(command, ' '))) << command;
  return {BriefHelp(call.set(), call.match), CommandHelp(call.set(), call.match)};
}

TEST(Help, FitsIntoEightyColumnsAndTheShortOneIntoAScreen) {
  for (const std::string& command : AllCommands()) {
    const auto [brief, whole] = Explain(command);
    const bool is_never_sent = brief.find("never an instant action") != std::string::npos;
    EXPECT_LE(std::count(brief.begin(), brief.end(), '\n'), is_never_sent ? 30 : 26) << brief;
    for (const std::string& line : base::Split(brief + whole, '\n')) {
      EXPECT_LE(base::MeasureWidth(line), 80U) << line;
    }
  }
  const std::string everyday = EverydayHelp();
  EXPECT_LE(std::count(everyday.begin(), everyday.end(), '\n'), 24);
  for (const std::string& line : base::Split(everyday, '\n')) EXPECT_LE(line.size(), 80U);
}

// An option's lines, without where they are broken.
std::set<std::string> OptionNames(const std::string& help) {
  const std::regex line("\n  (-[^ \n]*)");
  std::set<std::string> names;
  for (std::sregex_iterator it(help.begin(), help.end(), line), end; it != end; ++it) {
    names.insert((*it)[1]);
  }
  return names;
}

TEST(Help, InShortHasFiveOptionsBesideTheParameters) {
  for (const std::string& command : AllCommands()) {
    const auto [brief, whole] = Explain(command);
    const auto options = brief.find("\nOptions:\n");
    if (options == std::string::npos) continue;
    const std::size_t own =
        OptionNames(whole).size() - OptionNames(brief.substr(0, options)).size();
    EXPECT_EQ(OptionNames(brief.substr(options)).size(), std::min<std::size_t>(own, 5)) << brief;
  }
  const Helps position = Explain("initPosition");
  EXPECT_THAT(position.brief, AllOf(HasSubstr("--theta"), HasSubstr("--x 1.5 --y -2"),
                                    Not(HasSubstr("--actions-key"))));
  EXPECT_THAT(position.whole, HasSubstr("--actions-key"));
}

TEST(Suggestions, AreUnderstoodWhereverTheyStand) {
  const auto suggestions = testing::FindSuggestionsInSources();
  EXPECT_GT(suggestions.size(), 8U);
  for (const std::string& suggestion : suggestions) testing::ExpectUnderstood(suggestion);
}

TEST(Help, HasExamplesThatAreUnderstood) {
  const std::regex example("\n  (fleetpub (?:[^\\\\\n]|\\\\\n|\\\\.)*)");
  std::size_t count = 0;
  for (const std::string& command : AllCommands()) {
    const std::string help = Explain(command).whole;
    for (std::sregex_iterator it(help.begin(), help.end(), example), end; it != end; ++it) {
      testing::ExpectUnderstood((*it)[1]);
      ++count;
    }
  }
  EXPECT_GT(count, 80U);
}

TEST(Help, NamesMembersOfEachFamily) {
  for (const Subcommand& subcommand : Subcommands()) {
    const auto blank = subcommand.name.find(' ');
    if (blank == std::string_view::npos) continue;
    const std::string_view first = subcommand.name.substr(0, blank);
    if (FindSubcommandNamed(first) != nullptr) continue;
    ASSERT_NE(FindCommandFamily(first), nullptr) << first;
    EXPECT_THAT(FamilyHelp(*FindCommandFamily(first)),
                HasSubstr("  " + std::string(subcommand.name)));
  }
}

TEST(Help, OfEveryDayHasOnlyCommandsThatThereAre) {
  for (const EverydayCommand& command : EverydayCommands()) {
    EXPECT_TRUE(FindSubcommandNamed(command.name) || FindCommandFamily(command.name) ||
                vda5050::ActionCalled(command.name))
        << command.name;
    EXPECT_NE(command.summary, "") << command.name;
  }
}

}  // namespace
}  // namespace fleetpub::cli
