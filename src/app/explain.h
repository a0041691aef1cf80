// What became of one order or action of a robot, as a recording shows it, or the ledger and what the robot
// says now.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/verdict.h"
#include "base/result.h"
#include "base/time.h"
#include "recording/reader.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

struct ExplainRequest {
  vda5050::RobotAddress robot;
  VdaOptions vda;
  std::string order;           ///< its id
  std::string action;          ///< its id; both empty: the last order that is known
  std::filesystem::path file;  ///< a recording; empty: the ledger and the broker
  /// The broker is listened to for so long; nothing: until the robot's next state.
  std::optional<std::chrono::milliseconds> listen = {};
};

struct TimelineEntry {
  base::WallTime at;
  std::string text;  ///< printable
};

/// One obligation of VDA 5050, and whether the robot kept it.
struct ExplainFinding {
  std::string_view id;      ///< `taken`
  std::string_view clause;  ///< of 3.0, then of 2.1 where that is another: `6.6 / 6.10`
  Verdict verdict = Verdict::kInconclusive;
  std::string text;                   ///< printable
  std::vector<std::string> evidence;  ///< `state headerId 17`
};

struct Explanation {
  std::string order;
  std::string action;
  std::vector<TimelineEntry> timeline;
  std::vector<ExplainFinding> findings;
  recording::Faults faults;
};

/// Errors: ErrorKind::kUsage, kLedger, kInvalid, kBroker; kUnconfirmed: nothing is known of it. A ledger
/// that cannot be read hides only what it knows.
[[nodiscard]] Result<Explanation> Explain(const ExplainRequest& request,
                                          const Environment& environment, Log& log);

}  // namespace fleetpub::app
