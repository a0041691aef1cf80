#include "cli/output/fleet_browser.h"

#include <gmock/gmock.h>

#include <list>

namespace fleetpub::cli {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using Wish = FleetBrowser::Wish;

class Browsing : public ::testing::Test {
 protected:
  Browsing() {
    for (const char* serial : {"01", "02", "03", "04", "05", "06"}) {
      auto& robot =
          listed_.emplace_back(vda5050::RobotAddress{"KIT", serial}, vda5050::RobotEntry{});
      robot.second.base = std::make_shared<const vda5050::Dialect>();
      vda5050::LiveState state;
      state.operating_mode = std::string(serial) == "05" ? "MANUAL" : "AUTOMATIC";
      state.last_node_id = std::string("node-") + serial;
      robot.second.state = std::make_shared<const vda5050::LiveState>(state);
      robots_.push_back(&robot);
    }
  }
  // Seven lines: title, trouble, header, three robots and the place in the list.
  std::vector<std::string> Shown() {
    return browser_.Lines(robots_, {.size = {7, 100}, .now = {}, .title = "here", .trouble = "!"},
                          [](const auto&) { return std::nullopt; });
  }
  void Press(std::initializer_list<int> keys) {
    Shown();
    for (const int key : keys) EXPECT_EQ(browser_.Press(key), Wish::kNothing);
  }
  static auto Marked(const std::string& name) {
    return Contains(AllOf(HasSubstr("\x1b[7m"), HasSubstr(name)));
  }

  std::list<vda5050::ListedRobot> listed_;
  FleetBrowser::Robots robots_;
  Output output_{{}};
  FleetBrowser browser_{output_};
};

TEST_F(Browsing, ShowsAWindowOnTheTable) {
  const auto lines = Shown();
  ASSERT_THAT(lines, SizeIs(7));
  EXPECT_THAT(lines[0], AllOf(HasSubstr("6 robots, 0 online"), HasSubstr("q quits")));
  EXPECT_EQ(lines[1], "!");
  EXPECT_THAT(lines[3], HasSubstr("KIT/01"));
  EXPECT_THAT(lines[6], HasSubstr("1 to 3 of 6"));
  EXPECT_THAT(lines, Not(Contains(HasSubstr("\x1b["))));
}

TEST_F(Browsing, ScrollsWithTheMarkedRow) {
  Press({'j'});
  EXPECT_THAT(Shown(), Marked("KIT/01"));
  Press({kDown, 'j', 'j'});
  EXPECT_THAT(Shown(), AllOf(Marked("KIT/04"), Contains(HasSubstr("2 to 4 of 6"))));
  Press({'G'});
  EXPECT_THAT(Shown(), AllOf(Marked("KIT/06"), Contains(HasSubstr("4 to 6 of 6"))));
  Press({kPageUp});
  EXPECT_THAT(Shown(), Marked("KIT/03"));
  Press({'k', kUp});
  EXPECT_THAT(Shown(), Marked("KIT/01"));
  Press({kPageDown, kEnd, kHome, kOtherKey});
  EXPECT_THAT(Shown(), Marked("KIT/01"));
}

TEST_F(Browsing, KeepsTheMarkOnItsRobotWhenTheOrderChanges) {
  Press({'j', 'j'});
  std::swap(robots_[1], robots_[5]);
  EXPECT_THAT(Shown(), AllOf(Marked("KIT/02"), Contains(HasSubstr("4 to 6 of 6"))));
}

TEST_F(Browsing, FiltersByATextOfTheRow) {
  Press({'/', 'm', 'a', 'n', 'x', kBackspace});
  EXPECT_THAT(Shown(), AllOf(SizeIs(4), Contains(HasSubstr("/man_   1 of them"))));
  Press({kEnter});
  EXPECT_THAT(Shown(), Contains(HasSubstr("KIT/05")));
  EXPECT_EQ(browser_.Press('s'), Wish::kAsk);
  EXPECT_THAT(browser_.shown(), SizeIs(1));
  Press({kEscape});
  EXPECT_THAT(Shown(), SizeIs(7));
  Press({'/', 'q'});
  EXPECT_THAT(Shown(), Contains(HasSubstr("0 of them"))) << "q is text here";
  Press({kEscape});
  EXPECT_EQ(browser_.Press('q'), Wish::kQuit);
}

TEST_F(Browsing, OpensOneRobotAndComesBack) {
  for (const int back : {static_cast<int>(kEscape), static_cast<int>(kBackspace), int{'q'}}) {
    Press({'g', 'j', kEnter});
    const auto lines = Shown();
    EXPECT_THAT(lines[0], HasSubstr("KIT/02"));
    EXPECT_THAT(lines, Contains(HasSubstr("AUTOMATIC")));
    Press({back});
    EXPECT_THAT(Shown()[0], HasSubstr("6 robots"));
  }
  EXPECT_EQ(browser_.Press('q'), Wish::kQuit);
}

TEST_F(Browsing, ScrollsWithinOneRobot) {
  vda5050::LiveState state;
  state.action_states.assign(9, {.id = "a", .status = "WAITING"});
  listed_.front().second.state = std::make_shared<const vda5050::LiveState>(state);
  Press({kEnter});
  EXPECT_THAT(Shown(), Not(Contains(HasSubstr("errors"))));
  Press({'G'});
  EXPECT_THAT(Shown(), Contains(HasSubstr("errors")));
}

TEST_F(Browsing, ComesBackWhenTheRobotIsGone) {
  Press({'j', kEnter});
  robots_.erase(robots_.begin());
  EXPECT_THAT(Shown()[0], HasSubstr("5 robots"));
}

TEST_F(Browsing, ListsItsKeys) {
  Press({'?'});
  EXPECT_THAT(Shown()[0], HasSubstr("Keys"));
  Press({'q'});
  EXPECT_THAT(Shown()[0], HasSubstr("6 robots"));
}

TEST_F(Browsing, FitsAnyWindow) {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{1, 1}, {2, 5}, {3, 12}}) {
    for (const int key : {int{'G'}, static_cast<int>(kEnter), int{'G'}, int{'q'}}) {
      const auto lines = browser_.Lines(robots_, {.size = {rows, columns}, .now = {}},
                                        [](const auto&) { return std::nullopt; });
      EXPECT_LE(lines.size(), rows);
      EXPECT_EQ(browser_.Press(key), Wish::kNothing);
    }
  }
}

TEST(ReadEscapeSequence, KnowsWhatTerminalsSend) {
  EXPECT_EQ(ReadEscapeSequence("[A"), kUp);
  EXPECT_EQ(ReadEscapeSequence("OB"), kDown);
  EXPECT_EQ(ReadEscapeSequence("[6~"), kPageDown);
  EXPECT_EQ(ReadEscapeSequence("[200~"), kOtherKey);
}

}  // namespace
}  // namespace fleetpub::cli
