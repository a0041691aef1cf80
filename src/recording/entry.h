// What a recording consists of (docs/recording.md): a head, messages and events in order of arrival,
// and a foot.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"
#include "base/time.h"

namespace fleetpub::recording {

inline constexpr std::string_view kFormat = "fleetpub-recording";
inline constexpr int kFormatVersion = 1;

/// When something came.
struct Moment {
  std::chrono::microseconds t{0};  ///< since the recording began, by a clock that never jumps
  base::WallTime at;
};

struct Head {
  std::string tool;  ///< `fleetpub 1.0.0`
  base::WallTime started;
  std::string broker;        ///< without login
  std::string mqtt_version;  ///< `3.1.1`, `5`
  int qos = 0;               ///< at which was subscribed: none comes above it
  /// `retain` is what the publisher said; else only whether the broker had stored the message.
  bool retain_as_published = false;
  std::vector<std::string> subscriptions;
  std::chrono::microseconds time_zero{0};  ///< the monotonic clock when t was 0
  int part = 1;                            ///< of those into which it was rotated
};

/// The payload is bytes.
struct Message : Moment {
  std::string topic;
  std::string payload;
  int qos = 0;
  bool retain = false;
  bool dup = false;
};

struct Event : Moment {
  std::string kind;                     ///< `connected`, `lost`, `resubscribed`, `gap`, `overflow`
  std::string text = {};                ///< for a person; may be empty
  std::uint64_t messages = 0;           ///< overflow: so many could not be kept
  std::chrono::microseconds lasted{0};  ///< gap: nothing was heard for so long
};

struct Foot {
  base::WallTime ended;
  std::uint64_t count = 0;  ///< messages of this file
  std::string sha256;       ///< of all bytes before the foot, uncompressed
};

using Entry = std::variant<Head, Message, Event, Foot>;

/// One line with its end.
[[nodiscard]] std::string ToLine(const Head& head);
[[nodiscard]] std::string ToLine(const Message& message);
[[nodiscard]] std::string ToLine(const Event& event);
[[nodiscard]] std::string ToLine(const Foot& foot);

/// A message, an event … of our own, of `mosquitto_sub -F %j` and `%J`, of the doctor's envelope.
/// Times that a line does not say are those of `last`. Nothing: it says something else. Errors:
/// ErrorKind::kInvalid.
[[nodiscard]] Result<std::optional<Entry>> ParseJsonLine(std::string_view line, const Moment& last);

/// A row of mqtt-recorder's CSV; fields in quotation marks may hold line ends. Errors:
/// ErrorKind::kInvalid.
[[nodiscard]] Result<Message> ParseCsvRow(std::string_view row);

/// Whether a field in quotation marks goes on in the next line.
[[nodiscard]] bool IsOpenRow(std::string_view row);

}  // namespace fleetpub::recording
