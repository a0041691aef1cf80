// Completion, in real shells: what stands on the line after Tab.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <optional>

#include "base/file.h"
#include "base/json.h"
#include "support/broken_broker.h"
#include "support/operator.h"
#include "support/terminal.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

class Completion : public ::testing::Test {
 protected:
  Completion() {
    std::ofstream(home_ / "config.toml") << R"([profile.north]
broker = "mqtt://localhost:1"
[robot."KIT/0007"]
alias = "agv7"
[group]
hall-1 = ["agv7"]
)";
    std::ofstream(home_ / "plan.json") << "{}";
  }

  // With nothing of the host's configuration, and the binary in the path.
  [[nodiscard]] Command Prepare(std::vector<std::string> arguments) const {
    const std::string path = fs::path(Binary()).parent_path().string();
    return {.arguments = std::move(arguments),
            .environment = {{"PATH", path + ":" + std::getenv("PATH")},
                            {"HOME", home_.path().string()},
                            {"FLEETPUB_CONFIG", home_ / "config.toml"},
                            {"FLEETPUB_LEDGER", home_ / "ledger.db"}},
            .folder = home_.path().string()};
  }

  // In which the script is loaded.
  void Start(std::vector<std::string> shell, const std::string& load) {
    const std::string line = ShellLine(Prepare(std::move(shell)));
    terminal_.emplace("cd " + home_.path().string() + " && " + line, 160, 24);
    terminal_->Type(load + "; PS1='re''ady '; clear");
    terminal_->Press("Enter");
    ASSERT_TRUE(terminal_->Await("ready"));
  }

  // Types it and Tab, and waits for what becomes of the line.
  void ExpectCompleted(const std::string& typed, const std::string& line) {
    terminal_->Type(typed);
    terminal_->Press("Tab");
    ASSERT_TRUE(terminal_->Await(line));
  }

  std::optional<Terminal> terminal_;
  TemporaryFolder home_;
};

// What `__complete` answers, without the meanings.
std::vector<std::string> Candidates(std::vector<std::string> words) {
  words.insert(words.begin(), "__complete");
  const Operator someone;
  std::vector<std::string> texts;
  for (const std::string& line : Lines(someone.Fleetpub(words).output)) {
    texts.push_back(line.substr(0, line.find('\t')));
  }
  return texts;
}

TEST_F(Completion, KnowsCommandsOptionsAndTheirValues) {
  EXPECT_THAT(Candidates({"initP"}), ElementsAre("initPosition"));
  EXPECT_THAT(Candidates({"-b", "mqtt://x", "schema", ""}), ElementsAre("list", "show"));
  EXPECT_THAT(Candidates({"pause", "KIT/1", "--wait-"}), ElementsAre("--wait-for"));
  EXPECT_THAT(Candidates({"pause", "--wait-for", ""}), ElementsAre("accepted", "finished"));
  EXPECT_THAT(Candidates({"pause", "--blocking-type", ""}), ElementsAre("NONE"));
  EXPECT_THAT(Candidates({"pause", "--vda", "2.1", "--blocking-type", ""}),
              ElementsAre("NONE", "SOFT", "HARD"));
  EXPECT_THAT(Candidates({"simulate", "--mode", "TEACH"}), ElementsAre("TEACH_IN"));
  EXPECT_THAT(Candidates({"simulate", "--vda", "1.1", "--mode", "TEACH"}), ElementsAre("TEACHIN"));
  EXPECT_THAT(Candidates({"simulate", "--vda", "a"}), ElementsAre());
  EXPECT_THAT(Candidates({"publish", "o"}), ElementsAre("order"));
  EXPECT_THAT(Candidates({"pause", "--output=j"}), ElementsAre("--output=json"));
  EXPECT_THAT(Candidates({"pause", "-o", "j"}), ElementsAre("json"));
  EXPECT_THAT(Candidates({"pause", "--cafile", ""}), ElementsAre(":files"));
  EXPECT_THAT(Candidates({"initPosition", "KIT/1", "--map"}), ElementsAre("--mapId"));
  EXPECT_THAT(Candidates({"initPosition", "KIT/1", "--map-"}), ElementsAre("--map-id"));
  EXPECT_THAT(Candidates({"initPosition", "KIT/1", "--map-id", "m", "--map"}), ElementsAre());
  EXPECT_THAT(Candidates({"p"}), ElementsAre("pause", "publish", "ping"));
  EXPECT_THAT(Candidates({"action", "initPosition", "KIT/1", "-P", "last"}),
              ElementsAre("lastNodeId="));
  EXPECT_THAT(Candidates({"schema", "show", "soar"}), ElementsAre("soar/1.0/messages"));
  EXPECT_THAT(Candidates({"soar", "acknowledge", "x", "--status", "e"}), ElementsAre("executed"));
  EXPECT_THAT(Candidates({"respond", "KIT/1", "request-1", "R"}),
              ElementsAre("REVOKED", "REJECTED"));
  EXPECT_THAT(Candidates({"nonsense", ""}), ElementsAre());
  EXPECT_THAT(Candidates({"pause", "--help", "--vda", "2.1", "--no-such"}), ElementsAre());
  EXPECT_THAT(Candidates({}), Not(ElementsAre()));
}

TEST_F(Completion, WorksInBash) {
  Start({"bash", "--norc", "--noprofile", "-i"}, "eval \"`fleetpub completion bash`\"");
  ExpectCompleted("fleetpub initP", "fleetpub initPosition");
  ExpectCompleted("--lastN", "--lastNodeId");
  ExpectCompleted("n1 @ha", "n1 @hall-1");
  ExpectCompleted("ag", "@hall-1 agv7");
  ExpectCompleted("--output=j", "--output=json");
  ExpectCompleted("--cafile pl", "--cafile plan.json");
}

TEST_F(Completion, WorksInZsh) {
  Start({"zsh", "-f", "-i"},
        "autoload -U compinit; compinit -u; eval \"`fleetpub completion zsh`\"");
  ExpectCompleted("fleetpub initP", "fleetpub initPosition");
  ExpectCompleted("@ha", "initPosition @hall-1");
  ExpectCompleted("--profile n", "--profile north");
  ExpectCompleted("--cafile pl", "--cafile plan.json");
  ExpectCompleted("--output=j", "--output=json");
}

TEST_F(Completion, WorksInFish) {
  const auto ask = [&](const std::string& line) {
    const Finished run = fleetpub::testing::Run(Prepare(
        {"fish", "-N", "-c", "fleetpub completion fish | source; complete -C '" + line + "'"}));
    EXPECT_EQ(run.errors, "");
    return run.output;
  };
  EXPECT_THAT(ask("fleetpub initP"), StartsWith("initPosition\t"));
  EXPECT_THAT(ask("fleetpub pause @"), StartsWith("@hall-1\tgroup of 1"));
  EXPECT_THAT(ask("fleetpub validate pl"), HasSubstr("plan.json"));
}

// Thirty robots' names that a shell would obey, expand or cut; each begins with its number. One
// that ends in ; is the last: bash takes what follows such a word for a command.
std::vector<std::string> HostileNames() {
  constexpr std::string_view kTails[] = {"uniq;touch pwned",
                                         "`touch pwned`x",
                                         "a&touch pwned",
                                         "a|touch pwned",
                                         "a>pwned",
                                         "a<b",
                                         "(touch pwned)",
                                         "a;{ touch pwned; }",
                                         "!touch",
                                         "!!",
                                         "a b",
                                         " a  b ",
                                         "'a'",
                                         "'",
                                         "\"",
                                         "\"`touch pwned`\"",
                                         "\\",
                                         "a\\;touch pwned",
                                         "*",
                                         "?",
                                         "[ab]",
                                         "{a,b}",
                                         "~",
                                         "a=b",
                                         "a:b:c",
                                         "a@b",
                                         "%s",
                                         "-rf",
                                         "^a^b",
                                         "Straße 機 touch pwned;"};
  std::vector<std::string> names;
  for (const std::string_view tail : kTails) {
    names.push_back(fmt::format("Z{:02}/{}", names.size(), tail));
  }
  return names;
}

class HostileNamesIn : public Completion, public ::testing::WithParamInterface<const char*> {
 protected:
  // A `fleetpub` that completes as ours does and otherwise only writes down its arguments.
  void SetUp() override {
    std::string config;
    for (const std::string& name : HostileNames()) {
      config += "[robot." + base::JsonString(name) + "]\nvda = \"2.0\"\n";
    }
    std::ofstream(home_ / "config.toml") << config;
    fs::create_directory(home_ / "bin");
    std::ofstream(home_ / "bin/fleetpub")
        << "#!/bin/sh\ncase $1 in __complete|completion) exec " << Binary()
        << " \"$@\";; esac\nprintf '%s\\n' \"$@\" >got\n";
    fs::permissions(home_ / "bin/fleetpub", fs::perms::owner_all);
  }

  [[nodiscard]] Command Shell() const {
    const std::string shell = GetParam();
    Command command = Prepare(shell == "bash"  ? std::vector<std::string>{"bash", "--norc", "-i"}
                              : shell == "zsh" ? std::vector<std::string>{"zsh", "-f", "-i"}
                                               : std::vector<std::string>{"fish", "-N", "-i"});
    command.environment.emplace_back("PATH",
                                     fs::path(home_ / "bin").string() + ":" + std::getenv("PATH"));
    command.environment.emplace_back("LC_ALL", "C.UTF-8");
    return command;
  }

  void Load() {
    const std::string shell = GetParam();
    terminal_.emplace("cd " + home_.path().string() + " && " + ShellLine(Shell()), 160, 24);
    terminal_->Type(shell == "fish" ? "fleetpub completion fish | source; clear; echo re''ady"
                    : shell == "zsh"
                        ? "autoload -U compinit; compinit -u; eval \"`fleetpub completion zsh`\";"
                          "clear; echo re''ady"
                        : "eval \"`fleetpub completion bash`\"; clear; echo re''ady");
    terminal_->Press("Enter");
    ASSERT_TRUE(terminal_->Await("ready"));
  }
};

TEST_P(HostileNamesIn, AreOneWordEachAndRunNothing) {
  ASSERT_NO_FATAL_FAILURE(Load());
  const auto names = HostileNames();
  terminal_->Type("fleetpub pause ");
  for (std::size_t i = 0; i < names.size(); ++i) {
    terminal_->Type(fmt::format("Z{:02}", i));
    terminal_->Press("Tab");
  }
  terminal_->Type("; echo do''ne");
  terminal_->Press("Enter");
  ASSERT_TRUE(terminal_->Await("done"));
  auto got = Lines(base::ReadFile(home_ / "got").value());
  got.erase(got.begin());
  std::vector<std::string> words;
  for (const std::string& name : names) {
    words.push_back(vda5050::ParseRobotAddress(name).value().ToString());
  }
  EXPECT_EQ(got, words);
  EXPECT_FALSE(fs::exists(home_ / "pwned"));
}

INSTANTIATE_TEST_SUITE_P(Completion, HostileNamesIn, ::testing::Values("bash", "zsh", "fish"),
                         [](const auto& shell) { return std::string(shell.param); });

TEST_F(Completion, ConnectsToNothing) {
  std::atomic<int> connections = 0;
  const BrokenBroker server([&](int /*socket*/) { ++connections; });  // as broker and as database
  const Operator someone;
  const std::string ledger = server.Url("postgresql") + "/fleet?sslmode=disable";
  const std::vector<std::vector<std::string>> lines = {
      {"pause", ""}, {"soar", "observation", ""}, {"history", "--target", ""}};
  for (std::vector<std::string> words : lines) {
    words.insert(words.begin(), {"__complete", "--ledger", ledger, "-b", server.Url()});
    EXPECT_EQ(someone.Fleetpub(words).exit_code, 0);
  }
  EXPECT_EQ(connections, 0);
}

TEST_F(Completion, NamesTheShellsThatThereAre) {
  const Operator someone;
  const Finished run = someone.Fleetpub({"completion", "tcsh"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("bash, zsh or fish, not 'tcsh'"));
}

}  // namespace
}  // namespace fleetpub::testing
