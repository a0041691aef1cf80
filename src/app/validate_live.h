// `fleetpub validate --live`: listens, and holds whatever is published against the schemas.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "app/environment.h"
#include "app/fleet_discovery.h"
#include "app/observer.h"
#include "base/result.h"
#include "mqtt/transport.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::app {

struct LiveRequest {
  FleetRequest robots;  ///< whose messages; of it dialect and times do not count
  vda5050::ConformanceOptions conformance;  ///< its patterns are filled in
  mqtt::Deadline end = mqtt::Deadline::max();
  std::size_t count = SIZE_MAX;  ///< of messages, after which it ends
};

/// Whoever reads what was found.
class LiveObserver {
 public:
  virtual ~LiveObserver() = default;

  /// The broker has granted the subscription.
  virtual void Begin() = 0;
  /// A message was checked; or a robot has none where it must have one, and the message is empty.
  virtual void Checked(const mqtt::Message& message, const vda5050::ValidationResult& result) = 0;
  /// About every 100 ms: shows what was found. False: enough. Errors: nobody reads it.
  [[nodiscard]] virtual Result<bool> GoesOn() = 0;
};

struct LiveSummary {
  struct Tally {
    std::size_t messages = 0;
    std::size_t invalid = 0;
  };
  Tally all;
  std::map<std::string, Tally> by_topic;  ///< by its name
  std::size_t without_connection = 0;     ///< robots that send states, and have left none
};

/// Each message once: what is retained comes again with each new connection. Errors:
/// ErrorKind::kUsage, kBroker; the observer's.
[[nodiscard]] Result<LiveSummary> ValidateLive(LiveRequest request, const Environment& environment,
                                               LiveObserver& observer, Log& log);

}  // namespace fleetpub::app
