// Listens to whatever is said on topics: for those who write it down or show it as it is.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/targets.h"
#include "base/result.h"
#include "delivery/subscription.h"
#include "mqtt/transport.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::app {

struct ListenRequest {
  TargetRequest targets;  ///< no words: all robots
  VdaOptions vda;
  std::vector<std::string> topics;   ///< of VDA 5050: `state`; none: all
  std::vector<std::string> filters;  ///< of MQTT, in place of the robots' topics
  mqtt::Qos qos = mqtt::kListeningQos;
  mqtt::Deadline end = mqtt::Deadline::max();
};

/// Topics that are listened to.
class Listening {
 public:
  /// Errors: ErrorKind::kUsage, kBroker.
  [[nodiscard]] static Result<Listening> Open(ListenRequest request, const Environment& environment,
                                              delivery::ReconnectHooks hooks, Log& log);
  Listening(Listening&& other) noexcept;
  Listening& operator=(Listening&&) = delete;
  ~Listening();

  [[nodiscard]] const mqtt::ServerInfo& server() const;
  [[nodiscard]] const std::vector<std::string>& filters() const;
  [[nodiscard]] delivery::Subscription& subscription();
  /// Whose message it is; of null its topic is none of VDA 5050. False: it is not meant.
  [[nodiscard]] bool IsMeant(const std::string& topic,
                             std::optional<vda5050::TopicLevels>& levels) const;

 private:
  struct Parts;
  explicit Listening(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// Called on one thread.
class ListenObserver {
 public:
  virtual ~ListenObserver() = default;

  /// The broker has granted the subscription.
  [[nodiscard]] virtual Status Begin(const mqtt::ServerInfo& server,
                                     const std::vector<std::string>& filters) = 0;
  /// `levels`: whose message it is; null when its topic is none of VDA 5050. An error ends it all.
  [[nodiscard]] virtual Status Take(const mqtt::Message& message,
                                    const vda5050::TopicLevels* levels) = 0;
  /// The connection was lost and is opened again.
  virtual void Lost(const Error& error) = 0;
  virtual void ConnectedAgain() = 0;
  /// About every 100 ms. False: that was enough.
  [[nodiscard]] virtual Result<bool> GoesOn() = 0;
};

/// Until the request's end, or the observer has enough. Errors: ErrorKind::kUsage, kBroker, kLedger; the
/// observer's.
[[nodiscard]] Status Listen(ListenRequest request, const Environment& environment,
                            ListenObserver& observer, Log& log);

}  // namespace fleetpub::app
