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

void End(int signal) {
  EndAtOnce(signal, g_has_begun        ? "ended at once; fleetpub history lists what was sent"
                    : signal == SIGINT ? "interrupted: nothing was sent"
                                       : "terminated: nothing was sent");
}

}  // namespace

void EndAtOnce(int signal, std::string_view sentence) {
  if (Output::HasPassing()) WriteAtOnce("\r\x1b[K");
  WriteAtOnce("fleetpub: ");
  WriteAtOnce(sentence);
  WriteAtOnce("\n");
  _exit(128 + signal);
}

InterruptGuard::InterruptGuard() {
  g_has_begun = false;
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
