#include "cli/output/waiting_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <functional>

#include "base/width.h"

namespace fleetpub::cli {
namespace {

using std::chrono::seconds;

constexpr seconds kUntilShown{1};
constexpr std::chrono::milliseconds kBetween{250};

std::string FormatSeconds(std::chrono::nanoseconds time) {
  const auto count = std::max<std::int64_t>(1, std::chrono::round<seconds>(time).count());
  if (count < 60) return fmt::format("{} s", count);
  return count % 60 == 0 ? fmt::format("{} min", count / 60)
                         : fmt::format("{} min {:02} s", count / 60, count % 60);
}

// A signal is the main thread's: its system calls are to be interrupted.
std::thread StartWithoutSignals(const std::function<void()>& run) {
  sigset_t all;
  sigset_t old;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &old);
  std::thread thread(run);
  pthread_sigmask(SIG_SETMASK, &old, nullptr);
  return thread;
}

}  // namespace

std::string FormatWaiting(std::string_view what, std::string_view hint,
                          std::chrono::nanoseconds waited, std::chrono::nanoseconds limit,
                          std::size_t width) {
  std::string text = fmt::format("{}  {}", what, FormatSeconds(waited));
  if (limit < std::chrono::hours(24)) text += " of " + FormatSeconds(limit);
  const std::string whole = fmt::format("{}  ({})", text, hint);
  return hint.empty() || base::MeasureWidth(whole) > width ? text : whole;
}

WaitingLine::WaitingLine(Output& output)
    : output_(output), thread_(StartWithoutSignals([this] { Run(); })) {}

WaitingLine::~WaitingLine() {
  {
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
  output_.ClearPassing();
}

void WaitingLine::Set(std::string_view what, Clock::time_point limit, std::string_view hint) {
  {
    const std::scoped_lock lock(mutex_);
    if (what_.empty()) since_ = Clock::now();
    what_ = what;
    hint_ = hint;
    limit_ = limit;
    if (!what.empty()) return changed_.notify_one();
  }
  output_.ClearPassing();
}

void WaitingLine::Run() {
  std::unique_lock lock(mutex_);
  while (!is_ending_) {
    if (what_.empty()) {
      changed_.wait(lock);
      continue;
    }
    const auto now = Clock::now();
    if (now < since_ + kUntilShown) {
      changed_.wait_until(lock, since_ + kUntilShown);
      continue;
    }
    output_.Pass(FormatWaiting(what_, hint_, now - since_, limit_ - since_,
                               TerminalWidth(STDERR_FILENO) - 1));
    changed_.wait_for(lock, kBetween, [this] { return is_ending_; });
  }
}

}  // namespace fleetpub::cli
