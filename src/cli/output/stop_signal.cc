#include "cli/output/stop_signal.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>

#include "cli/output/interrupt.h"

namespace fleetpub::cli {
namespace {

std::atomic<int> g_signal = 0;
std::atomic<int> g_writer = -1;

// Inside a signal handler.
void Remember(int signal) {
  int none = 0;
  if (g_signal.compare_exchange_strong(none, signal)) {
    [[maybe_unused]] const auto ignored = write(g_writer, "", 1);
    return;
  }
  EndAtOnce(signal, "ended at once; fleetpub history lists what was sent");
}

}  // namespace

StopSignal::StopSignal() {
  g_signal = 0;
  std::array<int, 2> pipe_ends = {-1, -1};
  if (pipe2(pipe_ends.data(), O_CLOEXEC | O_NONBLOCK) == 0) {
    reader_ = pipe_ends[0];
    g_writer = pipe_ends[1];
  }
  struct sigaction action {};
  action.sa_handler = Remember;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
  if (reader_ < 0) return;
  close(reader_);
  close(g_writer.exchange(-1));
}

std::optional<ExitCode> StopSignal::Received() {
  if (g_signal == 0) return std::nullopt;
  return g_signal == SIGINT ? ExitCode::kInterrupted : ExitCode::kTerminated;
}

}  // namespace fleetpub::cli
