// What people write for robots, patterns, platforms, conditions and times.
#include "base/json.h"
#include "base/time.h"
#include "fuzz/fuzz.h"
#include "soar/destination.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/condition.h"

using namespace fleetpub;

FUZZ(text) {
  const auto robot = vda5050::ParseRobotAddress(text);
  if (robot) fuzz::Require(vda5050::ParseRobotAddress(robot->ToString()) == *robot);
  const auto pattern = vda5050::ParseRobotPattern(text);
  if (robot && pattern) fuzz::Require(pattern->Matches(*robot));
  if (pattern)
    static_cast<void>(pattern->Matches({"manufacturer", "aaaaaaaaaaaaaaaaaaaaaaaaaaaaab"}));
  static_cast<void>(soar::ParseDestination(text, {}, soar::MessageType::kMissionPlan));
  if (const auto prefix = soar::ParsePrefix(text)) static_cast<void>(prefix->Topic("a"));
  static const auto message =
      base::ParseJson(R"({"paused":true,"a":{"b":[1,"x"]},"batteryState":{"batteryCharge":80}})");
  if (const auto condition = vda5050::ParseCondition(text))
    static_cast<void>(vda5050::Unmet(*condition, *message));
  static_cast<void>(base::ParseDuration(text));
  if (const auto time = base::ParseDateTime(text)) {
    const std::string printed = base::FormatTimestamp(*time);
    const auto again = base::ParseDateTime(printed);
    fuzz::Require(again && base::FormatTimestamp(*again) == printed);
  }
}
