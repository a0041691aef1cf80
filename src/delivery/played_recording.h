// A recording in a broker's place: whoever listens to topics hears what was said then.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/result.h"
#include "base/time.h"
#include "mqtt/transport.h"
#include "recording/reader.h"

namespace fleetpub::delivery {

/// What of it is played.
enum class Play {
  kLast,  ///< the last message of each topic: how things stood at the end
  kAll,   ///< every one, in its order
};

/// One recording that is read as often as somebody subscribes. One thread at a time.
class PlayedRecording {
 public:
  PlayedRecording(std::filesystem::path path, Play play);

  /// Its transport takes subscriptions, each of which plays it from the beginning, as fast as it is
  /// read; after the last message it has ended. It publishes nothing. The recording must outlive it.
  /// Errors: ErrorKind::kLedger, kInvalid; kUsage: standard input is read once, so with Play::kAll
  /// for one subscription.
  [[nodiscard]] Result<std::unique_ptr<mqtt::Transport>> Open();

  /// When the last message that was handed out came; with Play::kLast, the last one there is.
  [[nodiscard]] base::WallTime now() const { return now_; }
  /// Since the first message.
  [[nodiscard]] std::chrono::nanoseconds elapsed() const { return elapsed_; }
  [[nodiscard]] std::string name() const { return path_.string(); }
  /// What is to be told of the file, once it has ended; "": nothing.
  [[nodiscard]] std::string Complaint() const;

 private:
  friend class RecordingTransport;

  std::filesystem::path path_;
  Play play_;
  base::WallTime now_;
  std::chrono::nanoseconds elapsed_{0};
  bool is_read_ = false;  // standard input
  recording::Faults faults_;
  std::optional<Error> trouble_;  // it could not be read to its end
};

}  // namespace fleetpub::delivery
