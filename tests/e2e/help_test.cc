// What fleetpub says of itself: each screen as it is shown at 80 columns, and through a pager.
#include <gmock/gmock.h>

#include <set>
#include <stdexcept>

#include "support/document.h"
#include "support/operator.h"
#include "support/suggestions.h"
#include "support/terminal.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;

class Help : public ::testing::Test {
 protected:
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  // In a terminal of so many rows, with this pager.
  [[nodiscard]] std::string Line(std::vector<std::string> arguments,
                                 std::optional<std::string> pager) const {
    Command command = operator_.Prepare(std::move(arguments));
    command.environment.emplace_back("PAGER", std::move(pager));
    command.environment.emplace_back("LESS", std::nullopt);
    return ShellLine(command) + "; echo exit code $?; sleep 100";
  }

  Operator operator_;
};

// A screen that changes changes its file: fleetpub pause -h > tests/data/help/pause.txt
TEST_F(Help, ShowsTheseScreens) {
  const std::pair<std::vector<std::string>, std::string> screens[] = {
      {{"-h"}, "everyday"},
      {{"pause", "-h"}, "pause"},
      {{"initPosition", "-h"}, "initPosition"},
      {{"history", "-h"}, "history"},
      {{"soar"}, "soar"},
      {{"actions", "initPosition"}, "actions-initPosition"},
  };
  for (const auto& [arguments, name] : screens) {
    const Finished shown = Fleetpub(arguments);
    EXPECT_EQ(shown.exit_code, 0);
    EXPECT_EQ(shown.output, SourceText("tests/data/help/" + name + ".txt"));
    EXPECT_EQ(shown.errors, "");
  }
  const Finished alone = Fleetpub({});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_EQ(alone.output, "");
  EXPECT_EQ(alone.errors, SourceText("tests/data/help/everyday.txt"));
}

TEST_F(Help, ListsTheMembersOfAFamily) {
  for (const std::string family : {"config", "ledger", "schema", "SoAR"}) {
    const Finished alone = Fleetpub({family});
    EXPECT_EQ(alone.exit_code, 0);
    EXPECT_EQ(alone.output, Fleetpub({family, "--help"}).output);
    EXPECT_EQ(alone.output, Fleetpub({"help", family}).output);
  }
  EXPECT_EQ(Fleetpub({"schema", "lsit"}).exit_code, 2);
  EXPECT_EQ(Fleetpub({"schema", "--lsit"}).exit_code, 2);
}

TEST_F(Help, ExplainsOneAction) {
  const Finished cancel = Fleetpub({"actions", "cancel"});
  EXPECT_EQ(cancel.exit_code, 0);
  EXPECT_THAT(cancel.output, AllOf(HasSubstr("cancelOrder, cancel"), HasSubstr("1.1.0 to 3.0.0"),
                                   HasSubstr("not in 1.1.0")));
  EXPECT_THAT(Fleetpub({"actions", "pick"}).output, HasSubstr("Never an instant action"));
  const auto objects = Lines(Fleetpub({"actions", "retry", "-o", "json"}).output);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_STREQ(Json(objects[0])["version"].GetString(), "3.0.0");
  EXPECT_EQ(Lines(Fleetpub({"actions", "pause", "-o", "json"}).output).size(), 4U);
  EXPECT_EQ(Lines(Fleetpub({"actions", "pause", "--vda", "2.1", "-o", "json"}).output).size(), 1U);
  EXPECT_EQ(Fleetpub({"actions", "retry", "--vda", "2.1"}).exit_code, 2);
  EXPECT_THAT(Fleetpub({"actions", "cancle"}).errors, HasSubstr("did you mean cancel?"));
}

TEST_F(Help, IsThereAsJsonForPrograms) {
  const Finished all = Fleetpub({"help", "-o", "json"});
  EXPECT_EQ(all.exit_code, 0);
  const auto help = Json(all.output);
  EXPECT_GT(help["commands"].Size(), 50U);
  EXPECT_EQ(help["exitCodes"].Size(), 11U);
  std::set<std::string> global;
  for (const auto& option : help["options"].GetArray()) {
    for (const auto& name : option["names"].GetArray()) global.insert(name.GetString());
  }
  EXPECT_THAT(global, IsSupersetOf({"-b", "--broker", "--help", "-o"}));

  const auto one = Json(Fleetpub({"pause", "--help", "-o", "json"}).output);
  ASSERT_EQ(one["commands"].Size(), 1U);
  const auto& options = one["commands"][0]["options"];
  const auto find = [&](const std::string& wanted) -> const base::JsonValue& {
    for (const auto& option : options.GetArray()) {
      for (const auto& name : option["names"].GetArray()) {
        if (name.GetString() == wanted) return option;
      }
    }
    throw std::runtime_error("no " + wanted);
  };
  EXPECT_STREQ(find("--wait-for")["type"].GetString(), "END");
  EXPECT_EQ(find("--wait-for")["choices"].Size(), 2U);
  EXPECT_FALSE(find("-w").HasMember("type"));
  EXPECT_STREQ(find("--vda")["default"].GetString(), "auto");
  EXPECT_STREQ(find("--vda")["variable"].GetString(), "FLEETPUB_VDA");
  EXPECT_TRUE(find("--except")["repeatable"].GetBool());
  EXPECT_EQ(Json(Fleetpub({"schema", "--help", "-o", "json"}).output)["commands"].Size(), 2U);
}

// ── words that people try ──

TEST_F(Help, AnswersWordsThatPeopleTryWithTheCommand) {
  const std::pair<std::vector<std::string>, std::string> words[] = {
      {{"stop", "KIT/0001"}, "fleetpub pause KIT/0001"},
      {{"HALT", "KIT/*", "--except", "KIT/0007"}, "fleetpub pause 'KIT/*' --except KIT/0007"},
      {{"continue", "KIT/0001", "--wait"}, "fleetpub resume KIT/0001 --wait"},
      {{"unpause", "--all", "-b", "mqtt://x"}, "fleetpub resume --all -b mqtt://x"},
      {{"abort", "KIT/o'neill"}, R"(fleetpub cancel 'KIT/o'\''neill')"},
      {{"ls"}, "fleetpub fleet"},
      {{"list", "-o", "json"}, "fleetpub fleet -o json"},
      {{"top"}, "fleetpub watch"},
      {{"log"}, "fleetpub history"},
      {{"lint", "a b.json"}, "fleetpub validate 'a b.json'"},
      {{"fleet", "KIT/*", "--json"}, "fleetpub fleet -o json 'KIT/*'"},
  };
  for (const auto& [arguments, suggestion] : words) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(FindSuggestions(run.errors), ElementsAre(suggestion));
    ExpectUnderstood(suggestion);
  }
  for (const std::string word : {"goto", "send"}) {
    const auto suggestions = FindSuggestions(Fleetpub({word, "KIT/0001"}).errors);
    ASSERT_EQ(suggestions.size(), 1U);
    ExpectUnderstood(suggestions.front());
  }
}

TEST_F(Help, RepeatsNoPasswordInAnAnswer) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"pause", "KIT/1", "--password", "geheim"},
                                             {"pause", "KIT/1", "--password=geheim"},
                                             {"stop", "KIT/1", "-P", "geheim"},
                                             {"ls", "--password=geheim"},
                                             {"fleet", "--json", "--passwd", "geheim"}}) {
    const Finished run = Fleetpub(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, Not(HasSubstr("geheim")));
  }
  EXPECT_THAT(Fleetpub({"ping", "--password", "x"}).errors, HasSubstr("--password-file"));
}

// ── the pager ──

TEST_F(Help, IsWholeThroughAPagerOnATerminal) {
  Terminal paged(Line({"--help"}, "sed \"s/^/paged: /\""), 90, 160);
  EXPECT_TRUE(paged.Await("paged:   config check"));
  EXPECT_TRUE(paged.Await("exit code 0"));
  Terminal standard(Line({"--help"}, std::nullopt), 80, 24);
  ASSERT_TRUE(standard.Await("Instant actions"));
  EXPECT_THAT(standard.Shown(), Not(HasSubstr("exit code")));  // it waits for a key
  standard.Press("q");
  EXPECT_TRUE(standard.Await("exit code 0"));
}

TEST_F(Help, NeedsNoPager) {
  for (const std::string pager : {"", "cat", "/no/such/pager --at-all"}) {
    Terminal terminal(Line({"pause", "--help"}, pager), 80, 100);
    EXPECT_TRUE(terminal.Await("Examples:")) << pager;
    EXPECT_TRUE(terminal.Await("exit code 0")) << pager;
  }
  Command piped = operator_.Prepare({"--help"});
  piped.environment.emplace_back("PAGER", "sed \"s/^/paged: /\"");
  EXPECT_THAT(testing::Run(std::move(piped)).output, StartsWith("fleetpub sends"));
  Terminal brief(Line({"pause", "-h"}, "sed \"s/^/paged: /\""), 80, 40);
  ASSERT_TRUE(brief.Await("exit code 0"));
  EXPECT_THAT(brief.Shown(), Not(HasSubstr("paged")));
}

}  // namespace
}  // namespace fleetpub::testing
