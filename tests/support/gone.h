// Whether a process that is nobody's child here has ended.
#pragma once

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "support/patience.h"

namespace fleetpub::testing {

/// Whether the process whose number is in this file ends in time. One that nobody has reaped has no
/// command line any more.
[[nodiscard]] inline bool HasGone(const std::string& file) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5 * kSlowness);
  int pid = 0;
  std::ifstream(file) >> pid;
  while (pid > 0 && std::chrono::steady_clock::now() < end) {
    std::string line;
    std::ifstream stream("/proc/" + std::to_string(pid) + "/cmdline");
    if (!std::getline(stream, line)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace fleetpub::testing
