// `fleetpub conform`: whether a robot keeps the standard, by listening, asking and driving.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/conformance/case.h"
#include "app/environment.h"
#include "app/follow_order.h"
#include "app/observer.h"
#include "base/result.h"
#include "layout/layout.h"

namespace fleetpub::app {

struct ConformRequest {
  FollowRequest robot;  ///< how it is found
  conformance::Selection selection;
  std::vector<std::string> nodes = {};            ///< of the way; none: straight on
  double distance = 2;                            ///< m, straight on
  std::shared_ptr<const layout::Site> site = {};  ///< may be null
  std::string vehicle_type = {};
  std::filesystem::path recording = {};  ///< takes all that is heard; empty: none
  std::string tool;                      ///< `fleetpub 1.0.0`, for the recording
};

struct ConformReport {
  std::string target;
  std::string version;
  conformance::Outcome outcome;
  std::string abort_reason;  ///< why not all could be run; "": all were
};

/// Agrees that it drives: `2.0 m straight on from where it stands, and back`. Errors: it may not.
using DriveConsent =
    std::function<Status(const vda5050::RobotAddress& robot, const std::string& extent)>;

/// Errors: ErrorKind::kUsage, kBroker, kLedger; kPreflight: the robot is unknown or offline, or there is no
/// such way; those of `consent`.
[[nodiscard]] Result<ConformReport> Conform(const ConformRequest& request,
                                            const Environment& environment,
                                            const DriveConsent& consent,
                                            const conformance::Progress& progress,
                                            Observer& observer);

}  // namespace fleetpub::app
