// How a command's target tells what became of it. Each protocol has its own; delivery only carries
// the messages.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time.h"
#include "message/command_status.h"

namespace fleetpub::message {

/// A message that arrived on one of a ResponseTracker's topics.
struct Incoming {
  std::string_view topic;
  std::string_view payload;
  /// The broker had stored it before we subscribed: it never confirms anything.
  bool retained = false;
};

/// What a target keeps of commands that have ended, until it is told to clear it.
enum class Kept : std::uint8_t {
  kNothing,
  kEntry,    ///< of this one
  kTooMuch,  ///< it says that there is no room left
};

/// How far a command has come.
struct Progress {
  bool seen = false;   ///< the target has shown that it knows the command
  bool ended = false;  ///< `status` is final
  /// Something came since that does not count, as it cannot be read: it may be the answer.
  bool unreadable = false;
  Kept kept = Kept::kNothing;
  CommandStatus status = CommandStatus::kTimeout;
  /// In a person's words: the target's result, description, hint; what it last said when it did not
  /// end. One line.
  std::string message = {};
};

/// That of a command whose end is known.
[[nodiscard]] inline Progress Ended(CommandStatus status, std::string message = {}) {
  return {.seen = true, .ended = true, .status = status, .message = std::move(message)};
}

/// Follows one command. Fed with the messages of its topics by one thread.
class ResponseTracker {
 public:
  ResponseTracker() = default;
  ResponseTracker(const ResponseTracker&) = delete;
  ResponseTracker& operator=(const ResponseTracker&) = delete;
  virtual ~ResponseTracker() = default;

  /// The topics to be subscribed, with the SUBACK awaited, before the command is published: exact
  /// ones, or filters where the answer's topic is not known beforehand.
  [[nodiscard]] virtual std::vector<std::string> Topics() const = 0;

  /// The command was published with this header id (again, when it is repeated). Messages that were
  /// received before are no answer, but what they said may explain a later one. That may be the end
  /// already.
  virtual void Published(std::uint32_t header_id) = 0;

  /// A message, before or after publishing. Lenient: whatever cannot be read is passed over, and
  /// told.
  virtual void Receive(const Incoming& message) = 0;

  /// After each Receive. Without an end the caller decides when time is up; `message` then is what
  /// to tell.
  [[nodiscard]] virtual const Progress& progress() const = 0;

  /// What a person wants to know before the end, since the last call: whole lines.
  [[nodiscard]] std::vector<std::string> TakeNews() { return std::exchange(news_, {}); }

 protected:
  void AddNews(std::string line) { news_.push_back(std::move(line)); }

 private:
  std::vector<std::string> news_;
};

}  // namespace fleetpub::message
