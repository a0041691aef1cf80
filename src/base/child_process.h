// A program that runs beside this one and cannot outlive it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"

namespace fleetpub::base {

/// Before a child is started: whoever started us may have had its children forgotten, and their ends
/// would be, too.
void KeepEndsOfChildren();

/// In a process group of its own, so that a terminal's Ctrl-C is this process's alone. What it writes
/// goes to memory, which never holds it up.
class ChildProcess {
 public:
  struct Command {
    std::vector<std::string> arguments;  ///< the first is the program's path
    std::string input;
    /// Laid over this process's environment; an empty value takes the variable out of it.
    std::vector<std::pair<std::string, std::string>> environment = {};
  };

  /// Errors: ErrorKind::kUnexpected with the system's reason.
  [[nodiscard]] static Result<std::unique_ptr<ChildProcess>> Start(const Command& command);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Ends it: as Terminate, and SIGKILL, to all of its group, when that has not helped within 5 s.
  ~ChildProcess();

  /// The exit code, or 128 + the signal that ended it; nothing while it runs.
  [[nodiscard]] std::optional<int> Poll();
  /// SIGTERM, once: who ends in an orderly way may take a second one for impatience.
  void Terminate();
  /// All that it wrote so far.
  [[nodiscard]] std::string Output() const;
  [[nodiscard]] std::string Errors() const;

 private:
  ChildProcess() = default;
  [[nodiscard]] bool Wait(std::chrono::milliseconds patience);

  pid_t pid_ = -1;
  int output_ = -1;
  int errors_ = -1;
  bool is_terminated_ = false;
  std::optional<int> exit_code_;
};

}  // namespace fleetpub::base
