// Writes a recording while it comes in, on a thread of its own: a slow disk must not keep anyone from
// reading the next message.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/result.h"
#include "recording/entry.h"

namespace fleetpub::recording {

/// When a new file begins; neither: never.
struct Rotation {
  std::optional<std::chrono::milliseconds> time;
  std::optional<std::uint64_t> bytes;  ///< of the file, as it is compressed
};

struct WriterOptions {
  std::filesystem::path path;
  Rotation rotation;
  Head head;
  /// So much may wait for the disk; what comes beyond it is lost, which an event says.
  std::size_t most_waiting = std::size_t{64} << 20;
};

/// What is in the files once it has ended.
struct Written {
  std::uint64_t messages = 0;
  std::uint64_t lost = 0;  ///< for want of room
  std::uint64_t bytes = 0;
  int files = 0;
};

class Writer {
 public:
  /// Creates the first file. Errors: ErrorKind::kLedger.
  [[nodiscard]] static Result<std::unique_ptr<Writer>> Open(WriterOptions options);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();

  /// Never waits. Errors: ErrorKind::kLedger: what came before could not be written.
  [[nodiscard]] Status Add(const Message& message);
  [[nodiscard]] Status Add(const Event& event);
  /// Writes what waits, and the foot. Once. Errors: as Add.
  [[nodiscard]] Result<Written> End();

 private:
  class Job;
  explicit Writer(std::unique_ptr<Job> job);
  std::unique_ptr<Job> job_;
};

}  // namespace fleetpub::recording
