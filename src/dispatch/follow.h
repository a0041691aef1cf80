// Waits for the targets' own word: feeds what arrives to the Confirmations and tells each command's
// end.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "dispatch/confirmation.h"
#include "dispatch/report.h"
#include "mqtt/transport.h"

namespace fleetpub::dispatch {

struct WaitOptions {
  /// How long a target may take to show that it knows the command: a silent robot may take 30 s to
  /// report.
  std::chrono::milliseconds seen{35'000};
  /// How long it may then take to end.
  std::chrono::milliseconds done{600'000};
  /// Both together, from the first publishing on; instead of the two.
  std::optional<std::chrono::milliseconds> total;
  /// How often a command that was not seen is sent again, with the same action ids.
  int resend = 0;
};

/// Follows commands that were published. Knows no connection: it is fed.
class Follower {
 public:
  using Clock = std::chrono::steady_clock;
  /// Told once for each command when its fate is known; the report is complete.
  using EndHook = std::function<void(const Report& report)>;

  Follower(const WaitOptions& options, EndHook ended);

  /// Registers a command under the caller's index before it is published. Keeps the pointer.
  void Watch(std::size_t index, Confirmation* confirmation);

  /// The topics and filters of the watched commands, each once.
  [[nodiscard]] std::vector<std::string> Topics() const;

  /// The command left; `report` says how, and is completed when the end is known.
  void Published(std::size_t index, Report report);

  /// A message arrived.
  void Deliver(const mqtt::Message& message);

  /// Ends those whose time is up. Returns those that were not seen in time and are to be sent
  /// again.
  [[nodiscard]] std::vector<std::size_t> Expire();

  /// Published and not ended.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }

  /// When somebody's time is up next; only while somebody waits.
  [[nodiscard]] Clock::time_point NextLimit() const;

 private:
  struct Watched {
    Confirmation* confirmation = nullptr;
    Report report = {};
    Clock::time_point published = {};
    Clock::time_point limit = {};
    int repeats = 0;
    bool open = false;
    bool seen = false;
  };

  void DeliverTo(const std::vector<std::size_t>& indices, const mqtt::Message& message);
  void Look(Watched& watched);
  void End(Watched& watched, Verdict verdict, const std::string& message);
  [[nodiscard]] std::chrono::milliseconds PatienceToBeSeen() const;

  WaitOptions options_;
  EndHook ended_;
  std::unordered_map<std::size_t, Watched> watched_;
  std::unordered_map<std::string, std::vector<std::size_t>> by_topic_;
  std::unordered_map<std::string, std::vector<std::size_t>> by_filter_;  // with wildcards
  std::size_t waiting_ = 0;
};

}  // namespace fleetpub::dispatch
