#include "cli/one_robot.h"

#include <fmt/format.h>

#include "base/text.h"
#include "cli/listening.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {

void DeclareRobot(OptionSet& set, RobotOptions& o) {
  set.AddOption("target", o.target, "The robot: manufacturer/serialNumber, or its alias")
      .Type("TARGET");
  DeclareStateWait(set, o.state_wait, "2s");
  set.AddFlag("--no-ask", o.no_ask, "Send no stateRequest: wait for the state that the robot sends")
      .Group("Waiting");
  DeclareVdaOptions(set, o.vda);
}

Result<app::Targets> ResolveTarget(const RobotOptions& o, std::string_view example,
                                   const Context& context) {
  if (o.target.empty()) {
    return Fail(ErrorKind::kUsage, fmt::format("name the robot: {}", example));
  }
  const auto spec = app::ParseTargetSpec({o.target}, context.config, context.output);
  if (!spec) return Fail(spec.error());
  if (spec->robots.size() != 1 || !spec->patterns.empty()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("this is for one robot, and {} may be several: name one",
                            base::Printable(o.target)));
  }
  auto targets = app::ResolveTargets({.words = {spec->robots.front().ToString()},
                                      .patterns = false,
                                      .all = false,
                                      .except = {},
                                      .where = {},
                                      .online = false,
                                      .state_wait = o.state_wait.value_or(kUsualStateWait)},
                                     context.config, context.output);
  return targets;
}

Result<app::FollowRequest> MakeFollowRequest(const RobotOptions& o, std::string_view example,
                                             const Context& context) {
  auto targets = ResolveTarget(o, example, context);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::Make(o.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  return app::FollowRequest{.targets = *std::move(targets),
                            .resolver = *std::move(resolver),
                            .ask = !o.no_ask,
                            .discover = MakeRetainedOptions(kUsualDiscover)};
}

}  // namespace fleetpub::cli
