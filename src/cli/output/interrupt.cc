#include "cli/output/interrupt.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <cstring>
#include <string_view>

#include "cli/output/output.h"

namespace fleetpub::cli {
namespace {

std::atomic<std::size_t> g_total = 0;  // 0: sending has not begun
std::atomic<std::size_t> g_sent = 0;

// Collects a line without allocating: everything here runs inside a signal handler.
class SignalSafeLine {
 public:
  void Add(std::string_view text) {
    const std::size_t count = std::min(text.size(), line_.size() - size_);
    std::memcpy(line_.data() + size_, text.data(), count);
    size_ += count;
  }
  void Add(std::size_t number) {
    const auto [end, error] =
        std::to_chars(line_.data() + size_, line_.data() + line_.size(), number);
    if (error == std::errc()) size_ = static_cast<std::size_t>(end - line_.data());
  }
  void Write() const {
    [[maybe_unused]] const auto ignored = write(STDERR_FILENO, line_.data(), size_);
  }

 private:
  std::array<char, 256> line_{};
  std::size_t size_ = 0;
};

void End(int signal) {
  SignalSafeLine line;
  if (Output::HasPassing()) line.Add("\r\x1b[K");
  line.Add(signal == SIGINT ? "fleetpub: interrupted: " : "fleetpub: terminated: ");
  if (g_total == 0) {
    line.Add("nothing was sent\n");
  } else if (g_sent == 0) {
    line.Add("perhaps a message was sent; fleetpub history tells\n");
  } else {
    line.Add(g_sent);
    line.Add(" of ");
    line.Add(g_total);
    line.Add(" messages were sent; fleetpub history lists them\n");
  }
  line.Write();
  _exit(128 + signal);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  g_total = 0;
  g_sent = 0;
  struct sigaction action {};
  action.sa_handler = End;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

void InterruptGuard::Begin(std::size_t total) { g_total = total; }

void InterruptGuard::CountSent() { ++g_sent; }

}  // namespace fleetpub::cli
