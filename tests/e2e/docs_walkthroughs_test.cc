// Pages of docs/, word for word: every command block, run one after the other as a reader would.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "layout/layouts.h"
#include "support/free_port.h"
#include "support/mosquitto.h"
#include "support/operator.h"

namespace fleetpub::testing {
namespace {

using ::testing::HasSubstr;

/// What stands in the page's `sh` blocks.
std::string ReadCommands(const std::string& name) {
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

TEST(DocsWalkthroughs, SetUpASite) {
  std::string commands = ReadCommands("site.md");
  ASSERT_THAT(commands, HasSubstr("fleetpub pause agv1 --profile north --wait"));
  Replace(commands, "8883", std::to_string(FreePort()));
  Replace(commands, "1884", std::to_string(FreePort()));
  const Finished run = RunPage(commands);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("reachable  MQTT 5"));
  EXPECT_THAT(run.output, HasSubstr("KIT/0001  startPause  FINISHED  "));
  EXPECT_THAT(run.output, HasSubstr("not authorized"));
  EXPECT_THAT(run.output, HasSubstr("exit 4\nexit 4\nexit 4\n"));
  EXPECT_THAT(run.errors, HasSubstr("from an authority that is not trusted here"));
}

// What a party could ask for to become more than it is. After the page, in its folder.
constexpr const char* kAttacks = R"sh(
mkfifo silence && exec 9<> silence
pretend() {             # pretend CHAIN KEY: a broker with this certificate; does it hear a login?
  openssl s_server -quiet -accept $FREE_PORT -cert $1 -cert_chain $1 -key $2 \
    <&9 > heard 2> /dev/null &
  server=$!
  for try in $(seq 200); do
    (: <> /dev/tcp/localhost/$FREE_PORT) 2> /dev/null && break
    sleep 0.02
  done
  fleetpub ping -b mqtts://localhost:$FREE_PORT --profile north --connect-timeout 2s \
    --cert "" --key "" --key-password-file "" \
    || echo "$1 exit $?, heard $(wc -c < heard)"
  kill $server
}
request judas -nodes -addext basicConstraints=critical,CA:TRUE \
  -addext keyUsage=critical,keyCertSign,digitalSignature -addext subjectAltName=DNS:localhost
party judas 0666
pretend judas.pem judas.key

sign() {                # sign FILE EXTENSION: with what judas got, as if it were an authority
  echo "$2" > "$1.ext"
  openssl x509 -req -in "$1.csr" -CA judas.pem -CAkey judas.key -CAcreateserial -days 9 \
    -extfile "$1.ext" -out "$1.pem"
  cat judas.pem >> "$1.pem"
}
request forged -nodes && sign forged subjectAltName=DNS:localhost
pretend forged.pem forged.key

openssl req -newkey rsa:2048 -nodes -subj /CN=ann -keyout false-ann.key -out false-ann.csr
sign false-ann extendedKeyUsage=clientAuth
fleetpub ping --profile north --cert false-ann.pem --key false-ann.key --key-password-file '' \
  || echo "false ann exit $?"
)sh";

TEST(DocsWalkthroughs, SetUpASiteWhereNobodyBecomesMoreThanTheAuthoritySaid) {
  std::string commands = ReadCommands("site.md");
  commands.resize(commands.find("fleetpub simulate"));
  Replace(commands, "8883", std::to_string(FreePort()));
  Replace(commands, "1884", std::to_string(FreePort()));
  std::string attacks = kAttacks;
  Replace(attacks, "$FREE_PORT", std::to_string(FreePort()));
  const Finished run = RunPage(commands + attacks);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  for (const std::string refused :
       {"judas.pem exit 4, heard 0\n", "forged.pem exit 4, heard 0\n", "false ann exit 4\n"}) {
    EXPECT_THAT(run.output, HasSubstr(refused)) << run.errors;
  }
}

TEST(DocsWalkthroughs, TellRecipesThatWork) {
  const std::string commands = ReadCommands("recipes.md");
  ASSERT_THAT(commands, HasSubstr("fleetpub fleet\n"));
  const std::string hall = FileText({NodeText("n1", 0, 0), NodeText("dock-3", 5, 0)},
                                    {EdgeText("n1", "dock-3"), EdgeText("dock-3", "n1")});
  const Mosquitto broker;
  const Finished run =
      RunPage("echo '" + hall + "' > hall.lif.json\nexport FLEETPUB_BROKER=" + broker.Url() +
              "\nfleetpub simulate KIT/0001 --count 3 --state-interval 1s --time-scale 10 --at n1 "
              "--layout hall.lif.json &\n"
              "fleetpub await KIT/0003 connection connectionState=ONLINE\n" +
              commands);
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("KIT/0099 is not there; nothing was sent\ngo and look"));
  EXPECT_THAT(run.output, HasSubstr("\"status\":\"FINISHED\"\n\"status\":\"FINISHED\"\n"));
  EXPECT_THAT(run.output, HasSubstr("n1 → dock-3, 5.0 m"));
  EXPECT_THAT(run.output, HasSubstr("CI/0001  startPause  FINISHED"));
  EXPECT_THAT(run.output, HasSubstr("KIT/0001  order  ACCEPTED"));
}

}  // namespace
}  // namespace fleetpub::testing
