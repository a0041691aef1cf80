// What .github/actions and .gitlab have the pipelines of others do, under bash, with a folder in the place of a release.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "support/free_port.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;
using Variables = std::map<std::string, std::string>;

base::JsonDocument ReadYaml(const std::string& path) {
  const char* as_json =
      "import json,sys,yaml; json.dump(yaml.safe_load(open(sys.argv[1])), sys.stdout, default=str)";
  return Json(testing::Run({.arguments = {"/usr/bin/python3", "-c", as_json,
                                          FLEETPUB_SOURCE_DIR "/" + path}})
                  .output);
}

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Replace(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), with);
    at += with.size();
  }
}

class Pipelines : public ::testing::Test {
 protected:
  // The program of the tests stands in for the static one.
  Pipelines() {
    const std::string make =
        "set -e; name=fleetpub-9.9.9-linux-$(uname -m)-static; mkdir -p release $name/bin tmp\n"
        "printf '#!/bin/sh\\nexec \"%s\" \"$@\"\\n' \"$BINARY\" >$name/bin/fleetpub; chmod +x "
        "$name/bin/fleetpub\n"
        "tar -czf release/$name.tar.gz $name; echo other >release/other.tar.gz\n"
        "cd release; sha256sum * >SHA256SUMS";
    EXPECT_EQ(Bash(make, {{"BINARY", Binary()}}).exit_code, 0);
  }
  // What its steps left running ends with it.
  ~Pipelines() override {
    static_cast<void>(
        Bash("kill $(pgrep -f \"$PWD/tmp/\"; pgrep -f \"$PWD/.fleetpub/\"; pgrep -f \"simulate "
             "$ROBOT \")",
             {{"ROBOT", robot_}}));
  }

  [[nodiscard]] Finished Bash(const std::string& script, const Variables& variables) const {
    Command command{.arguments = {"bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script},
                    .environment = {{"HOME", folder_.path().string()},
                                    {"FLEETPUB_LEDGER", folder_ / "ledger.db"},
                                    {"FLEETPUB_CONFIG", "/dev/null"}},
                    .folder = folder_.path().string()};
    for (const auto& [name, value] : variables) command.environment.emplace_back(name, value);
    return testing::Run(std::move(command));
  }

  TemporaryFolder folder_;
  std::string port_ = std::to_string(FreePort());
  std::string robot_ = "CI/" + port_;
};

/// As a runner does: `env` of each step with the inputs put in; what a step writes into GITHUB_ENV
/// and GITHUB_PATH holds for the next.
class ComposedAction : public Pipelines {
 protected:
  [[nodiscard]] Finished RunSteps(Variables inputs) {
    const auto action = ReadYaml(".github/actions/setup-fleetpub/action.yml");
    for (const auto& input : action["inputs"].GetObject()) {
      inputs.emplace(input.name.GetString(), input.value["default"].GetString());
    }
    Finished last{.exit_code = 0};
    for (const auto& step : action["runs"]["steps"].GetArray()) {
      if (!step.HasMember("run") ||
          (step.HasMember("if") && IsOff(step["if"].GetString(), inputs))) {
        continue;
      }
      EXPECT_STREQ(step["shell"].GetString(), "bash");
      last = Bash(step["run"].GetString(), Environment(step["env"], inputs));
      said_ += last.output + last.errors;
      if (last.exit_code != 0) break;
    }
    return last;
  }

  std::string said_;

 private:
  // `inputs.NAME != ''`
  static bool IsOff(const std::string& condition, const Variables& inputs) {
    const std::string name = condition.substr(std::string("inputs.").size());
    return inputs.at(name.substr(0, name.find(' '))).empty();
  }
  [[nodiscard]] Variables Environment(const base::JsonValue& env, const Variables& inputs) const {
    const std::string temporary = folder_ / "tmp";
    Variables variables = {{"RUNNER_TEMP", temporary},
                           {"GITHUB_ENV", folder_ / "env"},
                           {"GITHUB_PATH", folder_ / "path"}};
    for (const auto& one : env.GetObject()) {
      std::string value = one.value.GetString();
      for (const auto& [name, with] : inputs) Replace(value, "${{ inputs." + name + " }}", with);
      variables[one.name.GetString()] = value;
    }
    for (const std::string& line : Lines(ReadText(folder_ / "env"))) {
      variables[line.substr(0, line.find('='))] = line.substr(line.find('=') + 1);
    }
    std::string path = std::getenv("PATH");
    for (const std::string& line : Lines(ReadText(folder_ / "path"))) path = line + ":" + path;
    variables["PATH"] = path;
    return variables;
  }
};

TEST_F(ComposedAction, InstallsStartsAndLeavesAReport) {
  const Finished last = RunSteps({{"port", port_},
                                  {"robot", robot_},
                                  {"vda", "2.1"},
                                  {"conform", robot_},
                                  {"conform-for", "2s"}});
  EXPECT_EQ(last.exit_code, 0) << said_;
  EXPECT_THAT(said_, HasSubstr("reachable"));
  EXPECT_THAT(said_, HasSubstr("connectionState=ONLINE"));
  EXPECT_THAT(ReadText(folder_ / "fleetpub-conformance.xml"), HasSubstr("<testsuite"));
  EXPECT_EQ(ReadText(folder_ / "env"), "FLEETPUB_BROKER=mqtt://127.0.0.1:" + port_ + "\n");
}

TEST_F(ComposedAction, OnlyInstallsWhenThatIsAsked) {
  EXPECT_EQ(RunSteps({{"port", ""}, {"robot", ""}}).exit_code, 0) << said_;
  EXPECT_THAT(said_, HasSubstr("fleetpub "));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "env"));
}

TEST_F(ComposedAction, RefusesAReleaseWhoseSumIsAnother) {
  EXPECT_EQ(Bash("echo more >> release/fleetpub-*", {}).exit_code, 0);
  EXPECT_NE(RunSteps({{"port", port_}, {"robot", robot_}}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tmp/fleetpub/bin/fleetpub"));
}

TEST_F(Pipelines, OfGitLabInstallStartAndLeaveAReport) {
  const auto file = ReadYaml(".gitlab/fleetpub.yml");
  std::string script;
  for (const auto* part :
       {&file[".fleetpub"]["before_script"], &file[".fleetpub-conform"]["script"]}) {
    for (const auto& line : part->GetArray()) script += std::string(line.GetString()) + "\n";
  }
  Variables variables = {{"CI_PROJECT_DIR", folder_.path().string()}};
  for (const auto& one : file[".fleetpub"]["variables"].GetObject()) {
    variables[one.name.GetString()] = one.value.GetString();
  }
  Replace(variables["FLEETPUB_BROKER"], "18830", port_);
  variables["ROBOT"] = robot_;
  variables["CONFORM_FOR"] = "2s";
  const Finished run = Bash(script, variables);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(ReadText(folder_ / file[".fleetpub"]["artifacts"]["reports"]["junit"].GetString()),
              HasSubstr("<testsuite"));
}

TEST(OwnPipeline, EndsWithWhatAChangeMustPass) {
  const auto ci = ReadYaml(".github/workflows/ci.yml");
  const auto& steps = ci["jobs"]["test"]["steps"];
  EXPECT_STREQ(steps[steps.Size() - 1]["run"].GetString(), ".ci/run");
}

}  // namespace
}  // namespace fleetpub::testing
