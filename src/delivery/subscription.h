// Listens to topics for as long as somebody wants to, however often the connection is lost meanwhile.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "delivery/connect_hook.h"

namespace fleetpub::delivery {

/// Told when the connection is lost, and when another one is subscribed. Either may be empty.
struct ListenHooks {
  std::function<void(const Error&)> lost;
  std::function<void()> again;
};

/// A subscribed connection that is opened again whenever it is lost. One thread at a time.
class Subscription {
 public:
  /// Connects and subscribes. Nothing is tried after `end`. Errors: the first connection or
  /// subscription failed.
  [[nodiscard]] static Result<std::unique_ptr<Subscription>> Open(std::vector<std::string> filters,
                                                                  ConnectHook connect,
                                                                  ListenHooks hooks,
                                                                  mqtt::Deadline end);

  /// The next message, retained or not; nothing at the deadline, and earlier when the connection is
  /// lost. While there is none, tries to connect, which may take longer than the deadline, but
  /// never longer than `end`. What was published meanwhile and not retained is missed.
  [[nodiscard]] std::optional<mqtt::Message> Next(mqtt::Deadline deadline);

  [[nodiscard]] bool connected() const { return transport_ != nullptr; }
  void Disconnect();

 private:
  Subscription(std::vector<std::string> filters, ConnectHook connect, ListenHooks hooks,
               mqtt::Deadline end);
  [[nodiscard]] Status Connect();
  void TryAgain(mqtt::Deadline deadline);

  std::vector<std::string> filters_;
  ConnectHook connect_;
  ListenHooks hooks_;
  mqtt::Deadline end_;
  mqtt::Deadline next_try_{};
  std::unique_ptr<mqtt::Transport> transport_;
};

}  // namespace fleetpub::delivery
