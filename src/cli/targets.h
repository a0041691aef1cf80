// Whom a command is for: words of the command line (manufacturer/serialNumber, an alias, @group)
// as robots, each with the way in which it is spoken to.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/global_options.h"
#include "cli/vda_options.h"
#include "vda5050/instant_actions.h"

namespace fleetpub::cli {

struct AddressedRobot {
  vda5050::RobotAddress robot;
  vda5050::Dialect dialect;  ///< that it is spoken to in at first
  bool automatic = false;    ///< then in its own
};

struct Targets {
  std::vector<AddressedRobot> robots;
  std::string group;  ///< the first that was named, without @; empty: none
};

/// The robot that a target's word means, by address or alias; a group only when it has one member.
/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::RobotAddress> RobotOf(const std::string& word, const Config& config);

/// The robots in the order given; one that is named twice is commanded once, with a warning. What
/// `given` leaves open is the robot's own table's, the profile's, the file's. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<Targets> TargetsOf(const std::vector<std::string>& words,
                                        const VdaOptions& given, const Context& context);

/// The same without dialects.
[[nodiscard]] Result<std::vector<vda5050::RobotAddress>> RobotsOf(
    const std::vector<std::string>& words, const Context& context);

/// `given`, completed with what the configuration says of everybody.
[[nodiscard]] VdaOptions Configured(VdaOptions given, const Config& config);
/// `given`, completed with what the configuration says of this robot, and of everybody.
[[nodiscard]] VdaOptions Configured(VdaOptions given, const Config& config,
                                    const vda5050::RobotAddress& robot);

enum class Harm { kNone, kPossible };

/// Whether this instant action may go to a whole group unasked: to stop is never wrong, to ask
/// changes nothing.
[[nodiscard]] Harm HarmOf(std::string_view action_type);

/// Before a group is commanded: goes on when it is one robot, the message can do no harm, or
/// `yes`; else asks on a terminal. Errors: ErrorKind::kUsage: refused.
[[nodiscard]] Status Consent(const Targets& targets, Harm harm, bool yes);

}  // namespace fleetpub::cli
