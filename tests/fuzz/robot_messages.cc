// What a robot says about itself: a line with the topic, then the JSON. Reading, finding robots,
// the check before sending.
#include "base/text.h"
#include "fuzz/fuzz.h"
#include "vda5050/reports/robot_directory.h"
#include "vda5050/rules/preflight.h"

using namespace fleetpub;

FUZZ(text) {
  const auto [topic, payload] = fuzz::Cut(text, '\n');
  vda5050::KnownRobot known;
  if (auto connection = vda5050::ReadConnection(payload)) known.connection = *connection;
  if (auto state = vda5050::ReadState(payload)) known.operating_mode = state->operating_mode;
  if (auto factsheet = vda5050::ReadFactsheet(payload)) {
    known.factsheet = std::make_shared<const vda5050::Factsheet>(std::move(*factsheet));
    fuzz::Require(!vda5050::MakeActionId(known.factsheet.get()).empty());
  }
  const vda5050::InstantAction action{.type = "startPause", .id = "a"};
  for (const vda5050::Version version : vda5050::kVersions) {
    vda5050::Dialect dialect;
    dialect.version = version;
    static_cast<void>(vda5050::CheckRobot({"K", "1"}, dialect, std::span(&action, 1), known, 100));
  }
  const auto base = std::make_shared<const vda5050::Dialect>();
  vda5050::RobotDirectory fleet({}, [&](const auto&) { return std::pair(base, true); });
  fleet.AddScheme(base->topics);
  fleet.KeepStates();
  const auto* robot = fleet.Deliver(topic, payload, vda5050::Origin::kLive);
  if (robot != nullptr) static_cast<void>(vda5050::WeighTrouble(robot->second));
  static_cast<void>(vda5050::DialectFrom({}, topic, payload));
  fuzz::Require(base::IsUtf8(vda5050::Shown(payload)));
}
