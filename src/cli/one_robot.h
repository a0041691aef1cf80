// What the commands to one robot, which is looked up and listened to, have in common.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "app/follow_order.h"
#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/vda_options.h"

namespace fleetpub::cli {

class OptionSet;

/// Which one, and how it is spoken to.
struct RobotOptions {
  std::string target;
  std::optional<std::chrono::milliseconds> state_wait;
  bool no_ask = false;
  app::VdaOptions vda;
};

void DeclareRobot(OptionSet& set, RobotOptions& o);

/// `example`: a command to try when none is named. Errors: ErrorKind::kUsage: none, or several.
[[nodiscard]] Result<app::Targets> ResolveTarget(const RobotOptions& o, std::string_view example,
                                                 const Context& context);
[[nodiscard]] Result<app::FollowRequest> MakeFollowRequest(const RobotOptions& o,
                                                           std::string_view example,
                                                           const Context& context);

}  // namespace fleetpub::cli
