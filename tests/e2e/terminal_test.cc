// What people see in a terminal (a real emulator, tmux), and what is left of it in pipes and files.
#include "support/terminal.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

class OnATerminal : public EndToEnd {
 protected:
  [[nodiscard]] std::string Line(const std::vector<std::string>& arguments) const {
    return ShellLine(operator_.Prepare(arguments));
  }
  void SayConnection(const std::string& serial, const std::string& state) const {
    Say("vda5050/v3/KIT/" + serial + "/connection",
        fmt::format(R"({{"headerId":1,"timestamp":"2026-01-02T03:04:05.000Z","version":"3.0.0",)"
                    R"("manufacturer":"KIT","serialNumber":"{}","connectionState":"{}"}})",
                    serial, state),
        true);
  }
  // As a robot leaves that was there.
  void LeaveOffline(const std::string& serial) const { SayConnection(serial, "OFFLINE"); }
};

// Its end, and whether the terminal is as it was, are shown below it.
std::string AndTellTheEnd(const std::string& line) {
  return line + "; echo exit code $?; stty -a | grep -o -- '-\\?icanon'; sleep 100";
}

std::string Contents(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string FindRow(const std::string& name, const std::string& shown) {
  for (const std::string& line : Lines(shown)) {
    if (line.starts_with(name)) return line;
  }
  ADD_FAILURE() << "no " << name << " in:\n" << shown;
  return name;
}

// ── passwords ──

TEST_F(OnATerminal, APasswordThatIsNotTypedEndsTheCommandWithTheTerminalAsItWas) {
  const std::string report = (operator_.home().path() / "r.json").string();
  const std::string tell = "; echo exit code $?; stty -a | grep -ow -- '-\\?echo'; sleep 100";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"pause", "KIT/0001"},
        {"conform", "KIT/0001", "--report", "json=" + report},
        {"order", "follow", "KIT/0001"},
        {"watch"}}) {
    std::vector<std::string> call = words;
    call.insert(call.end(), {"--ask-password", "--username", "o"});
    Terminal terminal(Line(call) + tell, 80, 12);
    ASSERT_TRUE(terminal.Await("Password:")) << words[0];
    terminal.Type("secret");
    terminal.Press("C-c");
    EXPECT_TRUE(terminal.Await("nothing was sent\nexit code 130\necho")) << words[0];
    EXPECT_THAT(terminal.Shown(), Not(HasSubstr("secret")));
  }
}

TEST_F(OnATerminal, APasswordIsAskedForAgainAfterAStop) {
  const std::string file = operator_.home() / "pid";
  Terminal terminal("sh -c 'echo $$ > " + file + "; exec \"$@\"' - " +
                        Line({"ping", "--ask-password", "--username", "o"}) +
                        "; stty -a | grep -ow -- '-\\?echo'; sleep 100",
                    80, 12);
  ASSERT_TRUE(terminal.Await("Password:"));
  terminal.Type("sec");
  const int asking = std::stoi(Contents(file));
  EXPECT_EQ(kill(asking, SIGTSTP), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // SIGCONT takes back one under way
  EXPECT_EQ(kill(asking, SIGCONT), 0);
  ASSERT_TRUE(terminal.Await("Password:\nPassword:"));
  terminal.Type("secret\n");
  EXPECT_TRUE(terminal.Await("reachable"));
  EXPECT_TRUE(terminal.Await("\necho"));
}

// ── watch ──

TEST_F(OnATerminal, WatchRedrawsInPlaceAndRestoresTheScreen) {
  const auto robots = Robot({"KIT/0001", "--count", "9", "--state-interval", "100ms"});
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 100, 8);
  ASSERT_TRUE(terminal.Await("9 robots, 9 online"));
  ASSERT_TRUE(terminal.Await("1 to 4 of 9"));
  EXPECT_EQ(terminal.Flags(), "1 0\n");
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
  ASSERT_TRUE(terminal.Await("yes"));
  terminal.Resize(30, 14);
  ASSERT_TRUE(terminal.Await("KIT/0009"));
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("MODE")));
  terminal.Press("q");
  ASSERT_TRUE(terminal.Await("exit code 0\nicanon"));
  EXPECT_EQ(terminal.Flags(), "0 1\n");
}

TEST_F(OnATerminal, WatchWarnsOfANameThatMeansSomethingElse) {
  Command command{{"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(broker_.port()), "-r",
                   "-t", "vda5050/v3/KIT/?/connection", "-m",
                   R"({"version":"3.0.0","connectionState":"ONLINE"})"}};
  ASSERT_EQ(::fleetpub::testing::Run(std::move(command)).exit_code, 0);
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 120, 8);
  EXPECT_TRUE(terminal.Await("written with %"));
  EXPECT_TRUE(terminal.Await("KIT/%3F"));
}

TEST_F(OnATerminal, WatchRestoresItWhenInterruptedWithoutABroker) {
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 60, 8);
  ASSERT_TRUE(terminal.Await("0 robots"));
  broker_.Kill();
  ASSERT_TRUE(terminal.Await("was lost"));
  terminal.Press("C-c");
  ASSERT_TRUE(terminal.Await("exit code 0\nicanon"));
  EXPECT_EQ(terminal.Flags(), "0 1\n");
}

// In the middle of a drawing, too: states come all the time.
TEST_F(OnATerminal, WatchRestoresItWhateverEndsIt) {
  const auto robots = Robot({"KIT/0001", "--count", "20", "--state-interval", "10ms"});
  const std::string file = operator_.home() / "pid";
  const std::string watch = "sh -c 'echo $$ > " + file + "; exec \"$@\"' - " + Line({"watch"});
  const std::pair<int, int> ends[] = {{SIGTERM, 0},   {SIGINT, 0},    {SIGHUP, 129},
                                      {SIGQUIT, 131}, {SIGSEGV, 139}, {SIGABRT, 134}};
  for (const auto& [signal, code] : ends) {
    Terminal terminal("ulimit -c 0; " + AndTellTheEnd(watch), 80, 8);
    ASSERT_TRUE(terminal.Await("20 robots")) << signal;
    EXPECT_EQ(kill(std::stoi(Contents(file)), signal), 0);
    ASSERT_TRUE(terminal.Await("exit code " + std::to_string(code))) << signal;
    ASSERT_TRUE(terminal.Await("\nicanon")) << signal;
    EXPECT_EQ(terminal.Flags(), "0 1\n") << signal;
  }
}

TEST_F(OnATerminal, WatchShowsWhatMattersInEightyColumnsAndBreaksInNone) {
  const auto robots = Robot({"KIT/0001", "--with-order", "--state-interval", "50ms"});
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 80, 8);
  ASSERT_TRUE(terminal.Await("AUTOMATIC"));
  EXPECT_THAT(terminal.Shown(),
              AllOf(HasSubstr("1 robot, 1 online   q quits"),
                    HasSubstr("TARGET    CONNECTION  MODE       SAFETY  "), HasSubstr("ERRORS")));
  const std::pair<int, int> sizes[] = {{40, 5}, {12, 3}, {2, 2}, {1, 1}};
  for (const auto& [columns, rows] : sizes) {
    terminal.Resize(columns, rows);
    EXPECT_FALSE(terminal.Shown().empty());
  }
  terminal.Resize(40, 8);
  ASSERT_TRUE(terminal.Await("TARGET    CONNECTION  SAFETY  "));
  terminal.Press("q");
  ASSERT_TRUE(terminal.Await("exit code 0"));
}

TEST_F(OnATerminal, WatchScrollsFiltersAndOpensARobot) {
  const auto robots = Robot({"KIT/0001", "--count", "9", "--state-interval", "100ms"});
  const auto manual = Robot({"ACME/7", "--mode", "MANUAL", "--state-interval", "100ms"});
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 80, 8);
  ASSERT_TRUE(terminal.Await("10 robots, 10 online"));
  ASSERT_TRUE(terminal.Await("MANUAL"));
  EXPECT_THAT(Lines(terminal.Shown())[3], StartsWith("ACME/7"))
      << "what is not at work comes first";
  terminal.Press("End");
  ASSERT_TRUE(terminal.Await("7 to 10 of 10"));
  EXPECT_THAT(terminal.ShownInColour(), HasSubstr("\x1b[7m"));
  terminal.Press("Up");
  terminal.Press("Enter");
  ASSERT_TRUE(terminal.Await("KIT/0008   Esc comes back"));
  terminal.Press("Escape");
  ASSERT_TRUE(terminal.Await("7 to 10 of 10"));
  terminal.Press("/");
  terminal.Type("manual");
  ASSERT_TRUE(terminal.Await("/manual_   1 of them"));
  terminal.Press("Enter");
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("KIT/0001")));
  terminal.Press("Escape");
  ASSERT_TRUE(terminal.Await("KIT/0001"));
  terminal.Press("?");
  ASSERT_TRUE(terminal.Await("PgUp, PgDn"));
  terminal.Press("q");
  ASSERT_TRUE(terminal.Await("10 robots"));
  terminal.Press("q");
  ASSERT_TRUE(terminal.Await("exit code 0\nicanon"));
}

TEST_F(OnATerminal, WatchAlignsWideNamesAndKeepsItsColumns) {
  const std::vector<std::string> names = {"搬送/車一号", "Fo\u0308rd/🤖1", "KIT/0001",
                                          "a-very-long-maker/serial-0000017"};
  std::vector<std::unique_ptr<Process>> robots;
  for (const std::string& name : names) robots.push_back(Robot({name, "--state-interval", "50ms"}));
  Terminal terminal(AndTellTheEnd(Line({"watch"})), 140, 10);
  ASSERT_TRUE(terminal.Await("4 robots, 4 online"));
  const std::string shown = terminal.Shown();
  const std::string header = FindRow("TARGET", shown);
  const std::size_t column = header.find("VERSION");
  for (const std::string& name : names) {
    const std::string row = FindRow(name, shown);
    EXPECT_EQ(terminal.MeasureWidth(row.substr(0, row.find("3.0.0"))), column) << shown;
  }
  // The widest name goes; the columns stay where they are.
  robots.back()->Signal();
  ASSERT_TRUE(terminal.Await("3 online"));
  EXPECT_EQ(Fleetpub({"pause", "KIT/0001"}).exit_code, 0);
  ASSERT_TRUE(terminal.Await("yes"));
  EXPECT_EQ(FindRow("TARGET", terminal.Shown()), header);
}

TEST_F(OnATerminal, NoColourStandsAlone) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "50ms"});
  LeaveOffline("0002");
  const std::string line = Line({"watch"});
  Terminal coloured(AndTellTheEnd(line), 100, 8);
  ASSERT_TRUE(coloured.Await("2 robots, 1 online"));
  // Green, and dim for what a robot left that is gone: whoever sees neither reads the word.
  EXPECT_THAT(coloured.ShownInColour(),
              AllOf(HasSubstr("\x1b[32mONLINE"), HasSubstr("\x1b[2mOFFLINE")));
  Say("vda5050/v3/KIT/0002/connection",
      R"({"version":"3.0.0","connectionState":"CONNECTION_BROKEN"})", true);
  ASSERT_TRUE(coloured.Await("BROKEN"));
  EXPECT_THAT(coloured.ShownInColour(), HasSubstr("\x1b[1m\x1b[31mBROKEN"));
  Terminal plain(AndTellTheEnd("NO_COLOR=1 " + line.substr(line.find("-u NO_COLOR") + 12)), 100, 8);
  ASSERT_TRUE(plain.Await("2 robots, 1 online"));
  EXPECT_THAT(plain.ShownInColour(), Not(HasSubstr("\x1b[")));
}

// ── other tables ──

TEST_F(OnATerminal, FleetShowsAtOnceWhatIsKnownAndFillsIn) {
  const auto silent = Robot({"KIT/0001", "--count", "2", "--silent"});
  Terminal terminal(AndTellTheEnd(Line({"fleet", "--state-wait", "20s"})), 80, 8);
  ASSERT_TRUE(terminal.Await("waiting up to 20 s for 2 states"));
  EXPECT_THAT(terminal.Shown(), HasSubstr("KIT/0002  ONLINE"));
  const auto say = [&](const std::string& serial) {
    Say("vda5050/v3/KIT/" + serial + "/state",
        R"({"version":"3.0.0","operatingMode":"MANUAL","errors":[]})", false);
  };
  say("0001");
  ASSERT_TRUE(terminal.Await("for 1 state"));
  EXPECT_THAT(FindRow("KIT/0001", terminal.Shown()), HasSubstr("MANUAL"));
  say("0002");
  ASSERT_TRUE(terminal.Await("exit code 0"));
  const auto lines = Lines(terminal.Shown());
  EXPECT_THAT(lines.at(0), StartsWith("TARGET")) << "the table is there once";
  EXPECT_THAT(lines.at(3), StartsWith("exit code 0"));
}

TEST_F(OnATerminal, FleetFitsTheWindowAndIsWholeInAPipe) {
  const auto robot = Robot({"KIT/0001", "--state-interval", "50ms"});
  const auto wide = Robot({"搬送/車一号", "--state-interval", "50ms"});
  const std::string fleet = Line({"fleet"});
  Terminal terminal(AndTellTheEnd(fleet), 80, 8);
  ASSERT_TRUE(terminal.Await("exit code 0"));
  EXPECT_THAT(Lines(terminal.Shown())[0], AllOf(StartsWith("TARGET       CONNECTION"),
                                                HasSubstr("ERRORS"), Not(HasSubstr("SINCE"))));
  const std::string file = operator_.home() / "fleet";
  Terminal piped(AndTellTheEnd(fleet + " > '" + file + "'"), 40, 8);
  ASSERT_TRUE(piped.Await("exit code 0"));
  const auto lines = Lines(Contents(file));
  EXPECT_THAT(lines.at(0), AllOf(StartsWith("TARGET       VERSION"), HasSubstr("SINCE")));
  EXPECT_THAT(lines.at(1), StartsWith("KIT/0001     3.0.0"));
  EXPECT_THAT(lines.at(2), StartsWith("搬送/車一号  3.0.0"));
}

// At the two sizes that people have: what is shown of the fleet, and that nothing wraps or scrolls.
TEST_F(OnATerminal, WholeScreensFitBothSizes) {
  const auto robots = Robot({"KIT/0001", "--count", "12", "--state-interval", "100ms"});
  const auto trouble = Robot({"ACME/7", "--battery", "15", "--error", "motorFault:FATAL",
                              "--emergency-stop", "--with-order", "--state-interval", "100ms"});
  struct Size {
    int columns, rows;
    std::string header, trouble;
  };
  const Size sizes[] = {
      {80, 24, "TARGET +CONNECTION +MODE +SAFETY +PAUSED +BATTERY +ERRORS",
       "ACME/7 +ONLINE +AUTOMATIC +E-STOP +no +15% +1 FATAL motorFault"},
      {120, 40,
       "TARGET +VERSION +CONNECTION +SINCE +MODE +SAFETY +DRIVING +PAUSED +BATTERY +ORDER +ERRORS",
       "ACME/7 +3.0.0 +ONLINE +.* +AUTOMATIC +E-STOP +no +no +15% +order-1 +1 FATAL motorFault"}};
  for (const auto& [columns, rows, header, worst] : sizes) {
    Terminal fleet(AndTellTheEnd(Line({"fleet"})), columns, rows);
    ASSERT_TRUE(fleet.Await("exit code 0"));
    auto lines = Lines(fleet.Shown());
    EXPECT_THAT(lines.at(0), MatchesRegex(header));
    EXPECT_THAT(lines.at(1), MatchesRegex(worst));
    EXPECT_THAT(lines.at(13), StartsWith("KIT/0012"));
    EXPECT_THAT(lines.at(14), StartsWith("exit code 0"));

    Terminal watch(Line({"watch"}), columns, rows);
    ASSERT_TRUE(watch.Await("13 robots, 13 online, 1 in trouble"));
    ASSERT_TRUE(watch.Await("E-STOP"));
    lines = Lines(watch.Shown());
    EXPECT_THAT(lines.at(2), MatchesRegex(header));
    EXPECT_THAT(lines.at(3), StartsWith("ACME/7"));
    EXPECT_THAT(lines.at(15), StartsWith("KIT/0012"));

    Terminal show(AndTellTheEnd(Line({"show", "ACME/7"})), columns, rows);
    ASSERT_TRUE(show.Await("exit code 0"));
    lines = Lines(show.Shown());
    EXPECT_EQ(lines.at(0), "ACME/7") << "its first line is there still";
    EXPECT_THAT(show.Shown(), AllOf(HasSubstr("EMERGENCY STOP"), HasSubstr("FATAL motorFault"),
                                    HasSubstr("15 %"), HasSubstr("\n  commands ")));

    Terminal help(Line({"-h"}) + "; sleep 100", columns, rows);
    ASSERT_TRUE(help.Await("lists all of them"));
    EXPECT_THAT(help.Shown(), StartsWith("Commands for robots"));
  }
}

TEST_F(OnATerminal, ResultsAndHistoryAlignWideNames) {
  const Finished sent = Send({"pause", "搬送/車一号", "KIT/0001"});
  EXPECT_THAT(Lines(sent.output).at(0), StartsWith("搬送/車一号  startPause"));
  EXPECT_THAT(Lines(sent.output).at(1), StartsWith("KIT/0001     startPause"));
  const auto history = Lines(Fleetpub({"history"}).output);
  ASSERT_EQ(history.size(), 3U);
  EXPECT_THAT(history[1], HasSubstr("  搬送/車一号  startPause  "));
  EXPECT_THAT(history[2], HasSubstr("  KIT/0001     startPause  "));
  Terminal narrow(AndTellTheEnd(Line({"history"})), 40, 8);
  ASSERT_TRUE(narrow.Await("exit code 0"));
  EXPECT_THAT(Lines(narrow.Shown())[0], MatchesRegex(" +ID  TARGET       ACTION +STATUS"));
}

TEST_F(OnATerminal, HistoryShowsAsMuchAsFits) {
  ASSERT_EQ(Send({"pause", "KIT/0001", "KIT/0002", "KIT/0003", "KIT/0004", "KIT/0005", "KIT/0006",
                  "KIT/0007", "KIT/0008"})
                .exit_code,
            0);
  Terminal terminal(Line({"history"}) + "; sleep 100", 80, 9);
  ASSERT_TRUE(terminal.Await("KIT/0008"));
  EXPECT_THAT(terminal.Shown(), AllOf(HasSubstr("--limit 0"), HasSubstr("REASON"),
                                      HasSubstr("KIT/0003"), Not(HasSubstr("KIT/0002"))));
  const auto lines = Lines(Fleetpub({"history"}).output);
  EXPECT_EQ(lines.size(), 9U) << "elsewhere all";
}

// ── progress ──

class Progress : public OnATerminal {
 protected:
  // Six robots that have gone: each gets its pause, and a warning for its name.
  Progress() {
    for (int i = 1; i <= 6; ++i) LeaveOffline(fmt::format("r~000{}", i));
  }
  [[nodiscard]] std::string PauseAll() const {
    return Line({"pause", "--all", "--rate", "2", "--discover", "60"});
  }
};

std::vector<std::string> WhatIsLeft(Terminal& terminal) {
  std::vector<std::string> lines = Lines(terminal.Shown());
  std::erase(lines, "");
  return lines;
}

TEST_F(Progress, LeavesNothingBehindWhenWarningsAndResultsCome) {
  Terminal terminal(AndTellTheEnd(PauseAll()), 150, 24);
  ASSERT_TRUE(terminal.Await("=   ") && terminal.Await("of 6"));
  ASSERT_TRUE(terminal.Await("exit code 6"));
  const auto lines = WhatIsLeft(terminal);
  EXPECT_THAT(lines, Each(MatchesRegex("(fleetpub: warning: )?KIT/r~000[1-6].*|6 robots at .*|"
                                       "  offline  .*|exit code 6|icanon")));
  EXPECT_THAT(terminal.Shown(),
              HasSubstr("\nfleetpub: warning: KIT/r~0006: serial number 'r~0006'"));
}

TEST_F(Progress, StaysOnOneLineOfANarrowWindow) {
  Terminal terminal(AndTellTheEnd(PauseAll() + " 2>/dev/tty >/dev/null"), 36, 24);
  ASSERT_TRUE(terminal.Await("] 3 of 6"));
  ASSERT_TRUE(terminal.Await("exit code 6"));
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("[=")));
}

TEST_F(Progress, IsClearedWhenInterrupted) {
  Terminal terminal(AndTellTheEnd(PauseAll()), 150, 24);
  ASSERT_TRUE(terminal.Await("] 3 of 6"));
  terminal.Press("C-c");
  ASSERT_TRUE(terminal.Await("exit code 130"));
  EXPECT_THAT(terminal.Shown(), HasSubstr("not sent: interrupted"));
  EXPECT_THAT(terminal.Shown(), HasSubstr("6 robots at "));
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("[=")));
}

TEST_F(Progress, IsNotShownWhereItWouldGarble) {
  const std::string file = operator_.home() / "seen";
  for (const std::string& tail :
       {std::string(" | cat"), " 2>&1 | tee '" + file + "'", " > '" + file + "' 2>&1"}) {
    Terminal terminal(AndTellTheEnd(PauseAll() + tail), 150, 24);
    ASSERT_TRUE(terminal.Await("exit code "));
    EXPECT_THAT(terminal.Shown(), Not(HasSubstr("[=")));
    EXPECT_THAT(Contents(file), AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\r"))));
  }
  EXPECT_THAT(Lines(Contents(file)),
              Each(MatchesRegex("(fleetpub: warning: )?KIT/.*|6 robots at .*|  offline.*")));
}

TEST_F(OnATerminal, AWaitIsSeenAndCtrlCTellsWhoIsOpen) {
  SayConnection("0001", "ONLINE");
  Terminal terminal(AndTellTheEnd(Line({"pause", "KIT/0001", "--wait"})), 120, 24);
  ASSERT_TRUE(terminal.Await("waiting for KIT/0001: sent, not yet seen  ") &&
              terminal.Await(" s of 35 s  (Ctrl-C"));
  terminal.Press("C-c");
  ASSERT_TRUE(terminal.Await("exit code 130"));
  const auto lines = WhatIsLeft(terminal);
  EXPECT_THAT(lines[0], StartsWith("KIT/0001  startPause  INTERRUPTED")) << terminal.Shown();
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("waiting for")));
  const auto history = Json(Fleetpub({"history", "-o", "json"}).output);
  EXPECT_STREQ(history["status"].GetString(), "INTERRUPTED");
}

TEST_F(OnATerminal, OfManyRobotsItShowsWhoIsNotFinishedByReason) {
  const auto robots = Robot({"KIT/0001", "--count", "11"});
  SayConnection("0099", "ONLINE");
  const std::vector<std::string> call = {"pause", "--all", "--wait", "--timeout", "3s"};
  Terminal terminal(AndTellTheEnd(Line(call)), 80, 30);
  ASSERT_TRUE(terminal.Await("exit code 6"));
  const auto lines = WhatIsLeft(terminal);
  ASSERT_GE(lines.size(), 3U);
  EXPECT_THAT(lines[0], MatchesRegex("12 robots at .*: 11 finished, 1 unconfirmed .*"));
  EXPECT_THAT(lines[1], StartsWith("  TIMEOUT     KIT/0099  the robot has sent no state"));
  EXPECT_THAT(terminal.Shown(), Not(HasSubstr("FINISHED")));
  std::vector<std::string> whole = call;
  whole.emplace_back("-v");
  Terminal verbose(AndTellTheEnd(Line(whole)), 80, 50);
  ASSERT_TRUE(verbose.Await("exit code 6"));
  EXPECT_THAT(verbose.Shown(), HasSubstr("KIT/0011  startPause  FINISHED"));
  EXPECT_THAT(Lines(Fleetpub(call).output), SizeIs(14)) << "a pipe gets everything";
}

TEST_F(OnATerminal, BreaksLongLinesBetweenWords) {
  Terminal terminal(AndTellTheEnd(Line({"resume", "KIT/0099"})), 50, 24);
  ASSERT_TRUE(terminal.Await("exit code 7"));
  const auto lines = WhatIsLeft(terminal);
  ASSERT_GE(lines.size(), 3U) << terminal.Shown();
  EXPECT_THAT(lines[0], StartsWith("KIT/0099  stopPause  REFUSED"));
  EXPECT_THAT(lines[1], MatchesRegex("    [^ ].*"));
}

TEST_F(Progress, ShowsOnTheTerminalWhatGoesToAFile) {
  const std::string file = operator_.home() / "results";
  Terminal terminal(AndTellTheEnd(PauseAll() + " -o json > '" + file + "'"), 150, 24);
  ASSERT_TRUE(terminal.Await("of 6"));
  ASSERT_TRUE(terminal.Await("exit code 6"));
  EXPECT_THAT(Lines(Contents(file)), Each(StartsWith("{")));
}

// ── consent ──

TEST_F(OnATerminal, AsksBeforeManyAreCommanded) {
  const auto robots = Robot({"KIT/0001", "--count", "3"});
  for (const auto& [answer, end] : {std::pair("n", "exit code 2"), std::pair("y", "exit code 0")}) {
    Terminal terminal(AndTellTheEnd(Line({"charge", "--all"})), 40, 12);
    ASSERT_TRUE(terminal.Await("Send startCharging to 3 robots at mqtt:"));
    ASSERT_TRUE(terminal.Await("? [y/N]"));
    terminal.Press(answer);
    terminal.Press("Enter");
    ASSERT_TRUE(terminal.Await(end)) << answer;
    for (const std::string& line : WhatIsLeft(terminal))
      EXPECT_THAT(terminal.MeasureWidth(line), Le(40U));
  }
}

TEST_F(OnATerminal, KeepsTheConnectionWhileSomebodyThinks) {
  const auto robots = Robot({"KIT/0001", "--count", "3"});
  Terminal terminal(
      AndTellTheEnd(Line({"resume", "KIT/*", "--keep-alive", "1", "--client-id", "thinker"})), 80,
      12);
  ASSERT_TRUE(terminal.Await("? [y/N]"));
  ASSERT_TRUE(broker_.AwaitLog("PINGREQ from thinker"));
  terminal.Press("y");
  terminal.Press("Enter");
  ASSERT_TRUE(terminal.Await("exit code 0")) << terminal.Shown();
}

// Standard output is a file, and so is standard error: nobody could answer.
TEST_F(OnATerminal, AsksNobodyWhoCannotSeeTheQuestion) {
  const auto robots = Robot({"KIT/0001", "--count", "3"});
  const std::string file = operator_.home() / "errors";
  Terminal terminal(AndTellTheEnd(Line({"charge", "--all"}) + " 2> '" + file + "'"), 80, 12);
  ASSERT_TRUE(terminal.Await("exit code 2"));
  EXPECT_THAT(Contents(file), HasSubstr("--yes sends to all of them"));
}

}  // namespace
}  // namespace fleetpub::testing
