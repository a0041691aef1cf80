// Whom a command is for: words of the command line (manufacturer/serialNumber, an alias, @group, a
// pattern, `-` for standard input) as robots, each with the way in which it is spoken to.
#pragma once

#include <chrono>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/vda_options.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/condition.h"
#include "vda5050/reports/roster.h"

namespace fleetpub::cli {

struct TargetOptions {
  std::vector<std::string> words;
  bool patterns = false;  ///< also in lines of standard input
  bool all = false;
  std::vector<std::string> except;
  std::vector<std::string> where;
  std::string state_wait = "35s";
};

void DeclareTargetOptions(OptionSet& set, TargetOptions& options);

/// Robots of one make mostly share a dialect.
struct AddressedRobot {
  vda5050::RobotAddress robot;
  std::shared_ptr<const vda5050::Dialect> dialect;  ///< that it is spoken to in at first; not null
  bool automatic = false;                           ///< then in its own
};

/// How each robot is spoken to at first, as flags and configuration say.
class DialectResolver {
 public:
  /// Errors: ErrorKind::kUsage.
  [[nodiscard]] static Result<DialectResolver> For(const VdaOptions& given,
                                                   const config::Config& config);

  /// One that was named outright. Errors: ErrorKind::kUsage, in the robot's own table.
  [[nodiscard]] Result<AddressedRobot> Named(vda5050::RobotAddress robot) const;
  /// One that the broker knows: in its own version unless somebody states one.
  [[nodiscard]] Result<AddressedRobot> Found(vda5050::RobotAddress robot) const;

  /// The message says which version it is in: that of all for whom nobody states one.
  void Assume(vda5050::Version version);

  /// The shapes that robots' topics may have. Errors: ErrorKind::kUsage, in a robot's table.
  [[nodiscard]] Result<std::vector<vda5050::TopicScheme>> Schemes() const;

  /// How robots without a table of their own are spoken to.
  [[nodiscard]] const vda5050::Dialect& common() const { return *common_; }

 private:
  DialectResolver(VdaOptions given, const config::Config& config)
      : given_(std::move(given)), config_(&config) {}

  VdaOptions given_;
  const config::Config* config_;
  std::shared_ptr<const vda5050::Dialect> common_;
  bool automatic_ = false;
  std::optional<vda5050::Version> assumed_;
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
  std::chrono::milliseconds state_wait{};

  /// Whether the broker is asked which robots are meant.
  [[nodiscard]] bool AreFound() const { return !include.patterns.empty() || !where.empty(); }
  /// Whether a word stands for several.
  [[nodiscard]] bool IsSet() const { return !include.set.empty() || !where.empty(); }
  [[nodiscard]] bool IsExcepted(const vda5050::RobotAddress& robot) const;
};

/// The robot that a target's word means, by address or alias; a group only when it has one member.
/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::RobotAddress> RobotOf(const std::string& word,
                                                    const config::Config& config);

/// Words without `-`. One that is named twice outright counts once, with a warning. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<TargetSpec> ParseTargetSpec(const std::vector<std::string>& words,
                                                 const Context& context);

/// Reads standard input when that is asked. The excepted ones are taken out of those that are
/// named. Errors: ErrorKind::kUsage; kLedger: standard input cannot be read.
[[nodiscard]] Result<Targets> TargetsOf(const TargetOptions& options, const Context& context);

/// Robots named outright, for those who do not ask the broker.
[[nodiscard]] Result<std::vector<vda5050::RobotAddress>> RobotsOf(
    const std::vector<std::string>& words, const Context& context);

/// `given`, completed with what the configuration says of everybody.
[[nodiscard]] VdaOptions Configured(VdaOptions given, const config::Config& config);
/// `given`, completed with what the configuration says of this robot, and of everybody.
[[nodiscard]] VdaOptions Configured(VdaOptions given, const config::Config& config,
                                    const vda5050::RobotAddress& robot);

enum class NeedsConsent { kNo, kYes };

/// Whether this instant action may go to many robots unasked: to stop is never wrong, to ask
/// changes nothing.
[[nodiscard]] NeedsConsent ConsentFor(std::string_view action_type);

/// Asks on a terminal whether all of these are meant; `set` is the word that stands for them.
/// Errors: ErrorKind::kUsage: refused, or nobody is there to be asked.
[[nodiscard]] Status AskFor(std::span<const vda5050::RobotAddress> robots, std::string_view set);

/// Names in a sentence, the first twenty. Those with characters that the specification does not
/// recommend come first and are marked: they may look like another's.
[[nodiscard]] std::string ListOf(std::span<const vda5050::RobotAddress> robots);

/// Says of robots that the broker knows which ones cannot be named as they are called.
void WarnOfNames(std::span<const vda5050::RobotAddress> found, Output& output);

}  // namespace fleetpub::cli
