// docs/site.md, word for word: every command block, run one after the other as a reader would.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/free_port.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

/// What stands in the page's `sh` blocks.
std::string Commands() {
  std::ifstream page(FLEETPUB_SOURCE_DIR "/docs/site.md");
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

TEST(TheSite, IsSetUpByThePageAsItStands) {
  std::string commands = Commands();
  ASSERT_THAT(commands, HasSubstr("fleetpub pause agv1 --profile north --wait"));
  Replace(commands, "8883", std::to_string(FreePort()));
  Replace(commands, "1884", std::to_string(FreePort()));
  const TemporaryFolder home;
  const std::string folder = std::filesystem::path(Binary()).parent_path().string();
  const Finished run = fleetpub::testing::Run(
      {.arguments = {"bash", "-euc", "trap 'kill $(jobs -p); wait' EXIT\n" + commands},
       .environment = {{"HOME", home.path().string()},
                       {"PATH", folder + ":/usr/sbin:" + std::getenv("PATH")},
                       {"XDG_CONFIG_HOME", std::nullopt},
                       {"XDG_STATE_HOME", std::nullopt},
                       {"FLEETPUB_LEDGER", (home / "ledger.db").string()}},
       .folder = home.path().string()});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("reachable  MQTT 5"));
  EXPECT_THAT(run.output, ContainsRegex("KIT/0001  startPause  FINISHED  headerId 0 "));
  EXPECT_THAT(run.output, HasSubstr("not authorized"));
  EXPECT_THAT(run.output, ContainsRegex("exit 4\nexit 4\nexit 4\n"));
  EXPECT_THAT(run.output, Not(HasSubstr("exit 0")));
  EXPECT_THAT(run.errors, HasSubstr("from an authority that is not trusted here"));
}

}  // namespace
}  // namespace fleetpub::testing
