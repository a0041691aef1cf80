// Looks around, once or for long: which robots the broker knows, and what they say.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/result.h"
#include "config/config.h"
#include "delivery/retained.h"
#include "vda5050/reports/fleet_view.h"

namespace fleetpub::app {

struct FleetRequest {
  std::vector<std::string> words;  ///< robots and patterns; none: all
  VdaOptions vda;
  delivery::RetainedOptions discover;
  std::chrono::milliseconds state_wait{};
  bool ask = false;  ///< robots that are there for their states
};

/// The words as a person reads them; `all` without any.
[[nodiscard]] std::string FormatFleetName(const std::vector<std::string>& words);

/// What to say when so many robots' states could not be kept whole (FleetView::abridged).
[[nodiscard]] std::string AbridgedWarning(std::size_t robots);

/// Waits until every robot that is online has sent a state, asked for it or not, and warns of those
/// that did not in time. Errors: ErrorKind::kUsage, kBroker; kPreflight when no robot is known.
[[nodiscard]] Result<vda5050::FleetView> DiscoverFleet(const FleetRequest& request,
                                                       const Environment& environment, Log& log);

/// Shows a fleet as it is now. Called on one thread.
class FleetDisplay {
 public:
  virtual ~FleetDisplay() = default;

  virtual void Changed(const vda5050::RobotView& robot) = 0;
  /// The connection was lost and is opened again.
  virtual void Lost(const Error& error) = 0;
  virtual void ConnectedAgain() = 0;
  /// About every 100 ms. False: the person has seen enough.
  [[nodiscard]] virtual Result<bool> Refresh(const vda5050::FleetView& view) = 0;
};

/// Makes the display once the broker has granted the subscription.
using DisplayHook = std::function<std::unique_ptr<FleetDisplay>(const mqtt::BrokerUrl& broker)>;

/// Shows what the robots say until `end` or until the display has enough; of the request words and
/// dialect count. Errors: ErrorKind::kUsage, kBroker; the display's.
[[nodiscard]] Status WatchFleet(const FleetRequest& request, mqtt::Deadline end,
                                const Environment& environment, const DisplayHook& make_display,
                                Log& log);

}  // namespace fleetpub::app
