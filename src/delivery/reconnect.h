// How a connection that was lost is replaced: in one way, whoever holds it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "base/result.h"
#include "mqtt/transport.h"

namespace fleetpub::delivery {

/// Opens a connection to the same broker as always. By the deadline.
using ConnectHook =
    std::function<Result<std::unique_ptr<mqtt::Transport>>(mqtt::Deadline deadline)>;

struct ReconnectHooks {
  ConnectHook open;
  /// The connection was lost and is now opened again; it is there again. Either may be empty.
  std::function<void(const Error&)> lost;
  std::function<void()> again;
};

/// When to try. Who lost the connection to a client of the same id would throw that one out: by
/// then a command has done its work. Two that both wait do it ever more seldom; a connection that
/// has lasted starts afresh.
class ReconnectSchedule {
 public:
  using Clock = std::chrono::steady_clock;

  void Lost(Clock::time_point now);
  /// An attempt has failed.
  void Failed(Clock::time_point now) { next_ = now + pause_; }
  void Connected(Clock::time_point now) { connected_at_ = now; }
  /// When to try next.
  [[nodiscard]] Clock::time_point next() const { return next_; }

 private:
  Clock::time_point connected_at_{};
  Clock::time_point next_{};
  std::chrono::milliseconds pause_{0};
};

/// Opens a connection again. One thread at a time.
class Reconnector {
 public:
  explicit Reconnector(ReconnectHooks hooks) : hooks_(std::move(hooks)) {}

  void Lose(Error error);
  /// Why there is no connection at the moment.
  [[nodiscard]] const std::optional<Error>& lost() const { return lost_; }
  /// Whether somebody was told of it.
  [[nodiscard]] bool is_told() const { return is_told_; }

  /// Sleeps until it is time to try, or until the deadline. Then tries once, until `end` at most; a
  /// connection that `prepare` cannot ready is none. Null: it is lost still.
  [[nodiscard]] std::unique_ptr<mqtt::Transport> TryAgain(
      mqtt::Deadline deadline, mqtt::Deadline end,
      const std::function<Status(mqtt::Transport&)>& prepare);

 private:
  ReconnectHooks hooks_;
  ReconnectSchedule schedule_;
  std::optional<Error> lost_;
  bool is_told_ = false;
};

}  // namespace fleetpub::delivery
