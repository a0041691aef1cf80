// Whom a command is for: words of the command line (manufacturer/serialNumber, an alias, @group, a
// pattern, `-` for standard input) as robots.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/observer.h"
#include "base/result.h"
#include "config/config.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/condition.h"

namespace fleetpub::app {

/// What somebody asks for.
struct TargetRequest {
  std::vector<std::string> words;
  bool patterns = false;  ///< also in lines of standard input
  bool all = false;
  std::vector<std::string> except;
  std::vector<vda5050::Condition> where;
  bool online = false;  ///< only robots that are there
  std::chrono::milliseconds state_wait{};
  std::optional<std::size_t> expect = {};  ///< so many robots, or nothing is sent
};

/// Robots, and patterns whose robots only the broker knows.
struct TargetSpec {
  std::vector<vda5050::RobotAddress> robots;  ///< in the order given, each once
  std::vector<vda5050::RobotPattern> patterns;
  std::string set;  ///< the first word that may mean several; empty: none
};

struct Targets {
  TargetSpec include;
  TargetSpec except;
  std::vector<vda5050::Condition> where;
  bool online = false;
  std::chrono::milliseconds state_wait{};
  std::optional<std::size_t> expect = {};

  /// Whether the broker is asked which robots are meant.
  [[nodiscard]] bool AreFound() const { return !include.patterns.empty() || AskAll(); }
  /// Whether only what each robot says tells whether it is meant.
  [[nodiscard]] bool AskAll() const { return online || !where.empty(); }
  /// Whether a word stands for several.
  [[nodiscard]] bool IsSet() const { return !include.set.empty() || !where.empty(); }
  [[nodiscard]] bool IsExcepted(const vda5050::RobotAddress& robot) const;
};

/// The robot that a target's word means, by address or alias; a group only when it has one member.
/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::RobotAddress> ResolveRobot(const std::string& word,
                                                         const config::Config& config);

/// Words without `-`. One that is named twice outright counts once, with a warning. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<TargetSpec> ParseTargetSpec(const std::vector<std::string>& words,
                                                 const config::Config& config, Log& log);

/// Reads standard input when that is asked. The excepted ones are taken out of those that are
/// named. Errors: ErrorKind::kUsage; kLedger: standard input cannot be read.
[[nodiscard]] Result<Targets> ResolveTargets(TargetRequest request, const config::Config& config,
                                             Log& log);

/// Robots named outright, for those who do not ask the broker.
[[nodiscard]] Result<std::vector<vda5050::RobotAddress>> ResolveRobots(
    const std::vector<std::string>& words, const config::Config& config, Log& log);

enum class NeedsConsent { kNo, kYes };

/// Whether this instant action may go to many robots unasked: to stop is never wrong, to ask
/// changes nothing.
[[nodiscard]] NeedsConsent DecideConsent(std::string_view action_type);

/// Names in a sentence, the first twenty. Those with characters that the specification does not
/// recommend come first and are marked: they may look like another's.
[[nodiscard]] std::string FormatRobotList(std::span<const vda5050::RobotAddress> robots);

/// Which robots that the broker knows cannot be named as they are called; "": none.
[[nodiscard]] std::string DescribeEscapedNames(std::span<const vda5050::RobotAddress> found);
void WarnOfEscapedNames(std::span<const vda5050::RobotAddress> found, Log& log);

}  // namespace fleetpub::app
