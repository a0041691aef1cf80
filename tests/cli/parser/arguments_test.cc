#include "cli/parser/arguments.h"

#include <gmock/gmock.h>

#include "base/text.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

Result<SubcommandMatch> Find(std::vector<std::string> arguments) {
  GlobalOptions options;
  OptionSet set(OptionSet::Extent::kAll, {});
  DeclareGlobalOptions(set, options);
  return FindSubcommand(set, std::move(arguments));
}

// `command | the other arguments`, or the refusal.
std::string Found(const std::string& arguments) {
  const auto match =
      Find(arguments.empty() ? std::vector<std::string>() : base::Split(arguments, ' '));
  if (!match) {
    EXPECT_EQ(match.error().kind, ErrorKind::kUsage);
    return match.error().message;
  }
  return match->name + " | " + base::Join(match->arguments, " ");
}

TEST(FindSubcommand, TakesTheCommandFromAmongTheArguments) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"ping", "ping | "},
      {"action beep KIT/0001", "action | beep KIT/0001"},
      {"validate - --vda 2.1", "validate | - --vda 2.1"},
      {"pause KIT/0001", "pause | KIT/0001"},
      {"startPause KIT/0001 KIT/0002", "startPause | KIT/0001 KIT/0002"},
      {"pick KIT/0001", "pick | KIT/0001"},
      {"status KIT/0001", "show | KIT/0001"},
      {"ledger status", "ledger status | "},
  };
  for (const auto& [arguments, found] : kCases) EXPECT_EQ(Found(std::string(arguments)), found);
}

TEST(FindSubcommand, FindsNoneWhereThereIsNone) {
  EXPECT_EQ(Found(""), " | ");
  EXPECT_EQ(Found("--help"), " | --help");
  EXPECT_EQ(Found("--version --quiet"), " | --version --quiet");
  EXPECT_EQ(Found("-b mqtt://localhost"), " | -b mqtt://localhost");
}

TEST(FindSubcommand, PassesOverGlobalOptionsBeforeTheCommand) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"-b mqtt://h pause KIT/1", "pause | -b mqtt://h KIT/1"},
      {"--broker mqtt://h pause KIT/1", "pause | --broker mqtt://h KIT/1"},
      {"--broker=mqtt://h pause KIT/1", "pause | --broker=mqtt://h KIT/1"},
      {"-bmqtt://h pause KIT/1", "pause | -bmqtt://h KIT/1"},
      {"--quiet pause KIT/1", "pause | --quiet KIT/1"},
      {"-v --debug --insecure -o json pause KIT/1", "pause | -v --debug --insecure -o json KIT/1"},
      {"-b ping pause KIT/1", "pause | -b ping KIT/1"},
      {"--host ping ping", "ping | --host ping"},
  };
  for (const auto& [arguments, found] : kCases) EXPECT_EQ(Found(std::string(arguments)), found);
}

TEST(FindSubcommand, LeavesWhatStandsBehindTheCommandInItsOrder) {
  EXPECT_EQ(Found("initPosition KIT/1 --x 1.5 --y -2 -b mqtt://h"),
            "initPosition | KIT/1 --x 1.5 --y -2 -b mqtt://h");
  EXPECT_EQ(Found("pause -- KIT/1 ping"), "pause | -- KIT/1 ping");
}

TEST(FindSubcommand, LooksForNoCommandBehindTwoHyphens) {
  EXPECT_EQ(Found("-- pause KIT/1"), " | -- pause KIT/1");
}

TEST(FindSubcommand, TakesCommandsOfTwoWords) {
  EXPECT_EQ(Found("schema list"), "schema list | ");
  EXPECT_EQ(Found("schema show NAME"), "schema show | NAME");
  EXPECT_EQ(Found("--quiet schema -o json list"), "schema list | --quiet -o json");
  EXPECT_EQ(Found("history show 42"), "history show | 42");
}

TEST(FindSubcommand, PrefersTheCommandOfOneWordWhenTheSecondIsNone) {
  EXPECT_EQ(Found("history"), "history | ");
  EXPECT_EQ(Found("history --target KIT/1"), "history | --target KIT/1");
  EXPECT_EQ(Found("history shwo 42"), "history | shwo 42");
}

TEST(FindSubcommand, IgnoresLetterCase) {
  EXPECT_EQ(Found("PING"), "ping | ");
  EXPECT_EQ(Found("Schema LIST"), "schema list | ");
  EXPECT_EQ(Found("STARTPAUSE KIT/1"), "STARTPAUSE | KIT/1");
  EXPECT_EQ(Found("initposition KIT/1"), "initposition | KIT/1");
}

TEST(FindSubcommand, TellsSubcommandsFromPredefinedActions) {
  EXPECT_NE(Find({"ping"})->subcommand, nullptr);
  EXPECT_EQ(Find({"pause"})->subcommand, nullptr);
  EXPECT_EQ(Find({})->subcommand, nullptr);
}

TEST(FindSubcommand, KnowsTheFirstWordOfSeveral) {
  for (const char* word : {"schema", "SOAR", "config", "ledger"}) {
    const auto match = Find({word, "-v"});
    ASSERT_TRUE(match) << word;
    ASSERT_NE(match->family, nullptr) << word;
    EXPECT_EQ(match->name, "");
    EXPECT_EQ(match->arguments, std::vector<std::string>{"-v"});
  }
  EXPECT_EQ(Found("schema lsit"), "there is no command 'schema lsit': did you mean schema list?");
  EXPECT_EQ(Found("ledger wipe"), "there is no command 'ledger wipe'; there are status, migrate");
}

TEST(FindSubcommand, SuggestsTheNearestCommand) {
  constexpr std::pair<std::string_view, std::string_view> kCases[] = {
      {"order cancel KIT/1 --wait",
       "there is no command 'order cancel'; try: fleetpub cancelOrder KIT/1 --wait"},
      {"order status KIT/1",
       "there is no command 'order status'; try: fleetpub order follow KIT/1"},
      {"puase KIT/1", "there is no command 'puase': did you mean pause?"},
      {"startPuase KIT/1", "there is no command 'startPuase': did you mean startPause?"},
      {"pnig", "there is no command 'pnig': did you mean ping?"},
      {"validat x", "there is no command 'validat': did you mean validate?"},
      {"resum KIT/1", "there is no command 'resum': did you mean resume?"},
      {"unpuase KIT/1", "there is no command 'unpuase': did you mean resume?"},
  };
  for (const auto& [arguments, sentence] : kCases)
    EXPECT_EQ(Found(std::string(arguments)), sentence);
}

TEST(FindSubcommand, TellsHowToSendAnActionThatItDoesNotKnow) {
  for (const std::string word : {"makeCoffee", "-", "1.5"}) {
    EXPECT_EQ(Found(word + " x"), "there is no command '" + word +
                                      "': fleetpub --help lists them; a manufacturer's own action "
                                      "is sent with `fleetpub action TYPE TARGET`");
  }
}

TEST(FindSubcommand, SaysThatTheCommandComesFirst) {
  EXPECT_EQ(Found("KIT/0001 pause"),
            "the command comes before its target: fleetpub pause KIT/0001");
}

TEST(FindSubcommand, ShowsNoControlCharacter) {
  EXPECT_THAT(Found("\x1b[2J"), HasSubstr("'\\x1b[2J'"));
}

TEST(FindSubcommand, SurvivesOddArguments) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{{""},
                                                                     {"", ""},
                                                                     {"-"},
                                                                     {"--="},
                                                                     {"--=x"},
                                                                     {"-="},
                                                                     {"---"},
                                                                     {"-b"},
                                                                     {"--broker"},
                                                                     {"=", "ping"},
                                                                     {std::string(100'000, 'x')},
                                                                     {"\xFF"},
                                                                     {"-\xFF", "ping"},
                                                                     {"-1", "ping"}}) {
    const auto match = Find(arguments);
    EXPECT_TRUE(match || !match.error().message.empty());
  }
}

TEST(Subcommands, AreFoundUnderTheirNames) {
  for (const Subcommand& subcommand : Subcommands()) {
    EXPECT_EQ(Find(base::Split(subcommand.name, ' '))->subcommand, &subcommand);
    EXPECT_NE(subcommand.summary, "");
    EXPECT_THAT(std::string(subcommand.examples), StartsWith(std::string(subcommand.name)));
  }
}

}  // namespace
}  // namespace fleetpub::cli
