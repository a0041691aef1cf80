#include "cli/output/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <string_view>

#include "cli/output/output.h"

namespace fleetpub::cli {
namespace {

void WriteAtOnce(std::string_view text) {
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, text.data(), text.size());
}

std::atomic<bool> g_has_begun = false;
std::atomic<pid_t> g_companion = 0;

void End(int signal) {
  EndAtOnce(signal, g_has_begun        ? "ended at once; fleetpub history lists what was sent"
                    : signal == SIGINT ? "interrupted: nothing was sent"
                                       : "terminated: nothing was sent");
}

}  // namespace

void EndWithUs(pid_t process) { g_companion = process; }

void EndAtOnce(int signal, std::string_view sentence) {
  if (const pid_t companion = g_companion; companion != 0) kill(companion, SIGTERM);
  if (Output::HasPassing()) WriteAtOnce("\r\x1b[K");
  WriteAtOnce("fleetpub: ");
  WriteAtOnce(sentence);
  WriteAtOnce("\n");
  _exit(128 + signal);
}

InterruptGuard::InterruptGuard() {
  struct sigaction action {};
  action.sa_handler = End;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

void InterruptGuard::Begin() { g_has_begun = true; }

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

}  // namespace fleetpub::cli
