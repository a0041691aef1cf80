// Pages of docs/, word for word: every command block, run one after the other as a reader would.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/free_port.h"
#include "support/mosquitto.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

/// What stands in the page's `sh` blocks.
std::string CommandsOf(const std::string& name) {
  std::ifstream page(FLEETPUB_SOURCE_DIR "/docs/" + name);
  std::string commands;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      inside = line == "```sh";
    } else if (inside) {
      commands += line + "\n";
    }
  }
  return commands;
}

void Replace(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at)) {
    text.replace(at, what.size(), with);
  }
}

// In one shell, in an empty home; what it left in the background ends with it.
Finished RunPage(const std::string& commands) {
  const TemporaryFolder home;
  const std::string folder = std::filesystem::path(Binary()).parent_path().string();
  return Run({.arguments = {"bash", "-euc", "trap 'kill $(jobs -p); wait' EXIT\n" + commands},
              .environment = {{"HOME", home.path().string()},
                              {"PATH", folder + ":/usr/sbin:" + std::getenv("PATH")},
                              {"XDG_CONFIG_HOME", std::nullopt},
                              {"XDG_STATE_HOME", std::nullopt},
                              {"FLEETPUB_LEDGER", home / "ledger.db"}},
              .folder = home.path().string()},
             std::chrono::seconds(60));
}

TEST(Pages, SetUpASite) {
  std::string commands = CommandsOf("site.md");
  ASSERT_THAT(commands, HasSubstr("fleetpub pause agv1 --profile north --wait"));
  Replace(commands, "8883", std::to_string(FreePort()));
  Replace(commands, "1884", std::to_string(FreePort()));
  const Finished run = RunPage(commands);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("reachable  MQTT 5"));
  EXPECT_THAT(run.output, HasSubstr("KIT/0001  startPause  FINISHED  headerId 0 "));
  EXPECT_THAT(run.output, HasSubstr("not authorized"));
  EXPECT_THAT(run.output, HasSubstr("exit 4\nexit 4\nexit 4\n"));
  EXPECT_THAT(run.errors, HasSubstr("from an authority that is not trusted here"));
}

TEST(Pages, TellRecipesThatWork) {
  const std::string commands = CommandsOf("recipes.md");
  ASSERT_THAT(commands, HasSubstr("fleetpub fleet\n"));
  const Mosquitto broker;
  const Finished run = RunPage("export FLEETPUB_BROKER=" + broker.Url() +
                               "\nfleetpub simulate KIT/0001 --count 3 --state-interval 1s &\n"
                               "fleetpub await KIT/0003 connection connectionState=ONLINE\n" +
                               commands);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("KIT/0099 is not there; nothing was sent\ngo and look"));
  EXPECT_THAT(run.output, HasSubstr("\"status\":\"FINISHED\"\n\"status\":\"FINISHED\"\n"));
  EXPECT_THAT(run.output, HasSubstr("CI/0001  startPause  FINISHED"));
  EXPECT_THAT(run.output, HasSubstr("KIT/0001  order  ACCEPTED"));
}

}  // namespace
}  // namespace fleetpub::testing
