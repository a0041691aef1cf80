// `fleetpub batch`: sends the commands that lines ask for over one connection, as the lines come.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "app/batch_line.h"
#include "app/deliver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "base/line_reader.h"
#include "base/result.h"
#include "delivery/pending_commands.h"
#include "delivery/retained.h"

namespace fleetpub::app {

struct BatchRequest {
  LineDefaults defaults;
  delivery::WaitOptions wait;
  SendSettings settings;
  delivery::RetainedOptions discover;
  vda5050::TopicScheme topics;                  ///< of robots without a table of their own
  std::chrono::milliseconds reconnect{60'000};  ///< how long to try to connect again
  bool stop_on_error = false;
};

/// Whoever writes the lines and reads the results.
class BatchObserver {
 public:
  virtual ~BatchObserver() = default;

  /// The connection stands, and lines are read. Never with a dry run.
  virtual void Begin() = 0;
  /// One more message has left.
  virtual void Sent() = 0;
  /// What became of one command, or of a line that made none; the reference is its line's.
  virtual void Report(const message::Report& report) = 0;
  /// Shows what was reported so far. Errors: nobody reads it.
  [[nodiscard]] virtual Status Flush() = 0;
  /// Whether no further line is to be read.
  [[nodiscard]] virtual bool IsStopped() const = 0;
  /// Readable from then on. Asked once it has begun.
  [[nodiscard]] virtual int stop_descriptor() const = 0;
};

/// Why no further line was read.
enum class BatchStop : std::uint8_t { kEndOfInput, kStopped, kUnread, kFirstError, kNoConnection };

struct BatchEnd {
  BatchStop reason = BatchStop::kEndOfInput;
  bool all_read = true;  ///< it makes no difference
  std::size_t sent = 0;
  std::size_t last_line = 0;  ///< nothing was sent from the next one on
};

/// Sends until the lines end or something stops it, and waits for what is under way. With
/// SendSettings::dry_run reports what would be sent. Errors: nothing was sent.
[[nodiscard]] Result<BatchEnd> RunBatch(base::LineReader lines, BatchRequest request,
                                        const Environment& environment, BatchObserver& observer,
                                        Log& log);

}  // namespace fleetpub::app
