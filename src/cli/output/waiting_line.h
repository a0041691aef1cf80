// The one line that says what is waited for, and for how long already.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "cli/output/output.h"

namespace fleetpub::cli {

/// Draws the line once a second on a thread of its own, so that nobody who waits has to think of it.
/// It ends, and the line with it, when the object does.
class WaitingLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit WaitingLine(Output& output);
  WaitingLine(const WaitingLine&) = delete;
  WaitingLine& operator=(const WaitingLine&) = delete;
  ~WaitingLine();

  /// See app::Log::Wait. The seconds count from the first call, or the first after an empty one.
  void Set(std::string_view what, Clock::time_point limit, std::string_view hint);

 private:
  void Run();

  Output& output_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_ending_ = false;
  std::string what_;
  std::string hint_;
  Clock::time_point since_;
  Clock::time_point limit_;
  std::thread thread_;  // the last: it uses the others
};

/// `what  12 s of 35 s  (hint)`; without the hint when it does not fit.
[[nodiscard]] std::string FormatWaiting(std::string_view what, std::string_view hint,
                                        std::chrono::nanoseconds waited,
                                        std::chrono::nanoseconds limit, std::size_t width);

}  // namespace fleetpub::cli
