// Listens to topics for as long as somebody wants to, however often the connection is lost meanwhile.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "delivery/reconnect.h"
#include "delivery/retained.h"

namespace fleetpub::delivery {

/// A subscribed connection that is opened again whenever it is lost. One thread at a time.
class Subscription {
 public:
  /// Subscribes over an open connection. Nothing is opened again after `end`. Errors: the
  /// subscription failed.
  [[nodiscard]] static Result<Subscription> Open(std::unique_ptr<mqtt::Transport> transport,
                                                 std::vector<std::string> filters,
                                                 ReconnectHooks hooks, mqtt::Deadline end,
                                                 mqtt::Qos qos = mqtt::kListeningQos);

  /// Hands over what comes, retained or not, until `end`, until it was the last that is wanted, or
  /// until `goes_on`, asked about every 100 ms, says no; that may be empty. Looks once at least, and
  /// ends where a recording does. What
  /// was published while there was no connection, and not retained, is missed. Errors: those of
  /// `goes_on`.
  [[nodiscard]] Status Read(const MessageCallback& take,
                            const std::function<Result<bool>()>& goes_on = {});

  /// The next message; nothing at the deadline, and earlier when the connection is lost. While there
  /// is none, tries to connect, which may take longer than the deadline, but never longer than `end`.
  [[nodiscard]] std::optional<mqtt::Message> Next(mqtt::Deadline deadline);

  /// Lends the connection, if there is one, to somebody who sends. Left null, it was lost.
  void Lend(const std::function<void(std::unique_ptr<mqtt::Transport>& transport)>& use);

  /// The connection; null while it is lost.
  [[nodiscard]] mqtt::Transport* transport() const { return transport_.get(); }
  void Disconnect();

 private:
  Subscription(std::vector<std::string> filters, ReconnectHooks hooks, mqtt::Deadline end,
               mqtt::Qos qos)
      : filters_(std::move(filters)), reconnector_(std::move(hooks)), end_(end), qos_(qos) {}
  [[nodiscard]] Status Subscribe(mqtt::Transport& transport, mqtt::Deadline end) const;

  std::vector<std::string> filters_;
  Reconnector reconnector_;
  mqtt::Deadline end_;
  mqtt::Qos qos_;
  std::unique_ptr<mqtt::Transport> transport_;
};

}  // namespace fleetpub::delivery
