// `fleetpub doctor`: what is wrong with a broker and with the fleet at it, and what to do about it.
// Listens; sends nothing to robots.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/expected_robots.h"
#include "app/fleet_evidence.h"
#include "app/targets.h"
#include "base/result.h"

namespace fleetpub::app {

enum class Health { kOk, kWarning, kProblem, kUnknown };

/// What to do: a command, word by word, or else advice. Both may be empty.
struct Remedy {
  std::vector<std::string> command = {};
  std::string advice = {};
};

/// What a check has found. Text and advice are printable.
struct Diagnosis {
  std::string_view check;  ///< `header-ids`
  Health health = Health::kOk;
  std::string subject;  ///< a robot, `12 robots`, a broker, a file
  std::string text = {};
  Remedy remedy = {};
  ErrorKind kind = ErrorKind::kInvalid;  ///< decides the exit code, when it is a problem
};

/// Called as each is found.
using DiagnosisHook = std::function<void(const Diagnosis& diagnosis)>;

/// What was listened to, and for how long.
struct ListeningFacts {
  std::chrono::nanoseconds elapsed{0};
  std::set<std::string, std::less<>> refused = {};  ///< topics: `order`
  std::optional<mqtt::BrokerUrl> broker = {};       ///< nothing: a recording
  bool knows_retained = true;                       ///< whether the broker keeps messages
  std::vector<vda5050::RobotAddress> named = {};    ///< whom the words mean outright
  std::vector<ExpectedRobot> expected = {};         ///< whom configuration and ledger know
};

/// Every check of the fleet, in order; each says something.
void ExamineFleet(const FleetEvidence& evidence, const ListeningFacts& listening,
                  const DiagnosisHook& tell);

struct DoctorRequest {
  TargetRequest targets;  ///< no words: all robots
  VdaOptions vda;
  std::chrono::milliseconds duration =
      vda5050::kLongestSilence;  ///< a recording is read to its end
  bool listens = true;           ///< else only the broker is examined
  /// The broker has granted the subscription, and is listened to now. May be empty.
  std::function<void()> begin = {};
  /// About every 100 ms while listening: false ends it. May be empty.
  std::function<Result<bool>()> goes_on = {};
};

/// Tells what is wrong with the broker, our rights there, and the fleet. Returns how many robots were
/// heard; a broker that cannot be reached is a diagnosis. Errors: ErrorKind::kUsage, kBroker (while
/// listening), kLedger; those of `goes_on`.
[[nodiscard]] Result<std::size_t> Diagnose(const DoctorRequest& request,
                                           const Environment& environment,
                                           const DiagnosisHook& tell, Log& log);

}  // namespace fleetpub::app
