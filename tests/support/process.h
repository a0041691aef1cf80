// A child process of a test, that cannot outlive it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/patience.h"

namespace fleetpub::testing {

struct Command {
  std::vector<std::string> arguments;  ///< the first is the program, looked for in PATH
  /// Added to this process's environment, or replacing what is in it; without a value: taken out of
  /// it.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment = {};
  /// Standard input, which then ends; nothing: a pipe that Write() feeds.
  std::optional<std::string> input = std::string();
  std::string folder = {};  ///< to run in; empty: this one
};

/// Output goes to memory, so that a child never blocks on it. Killed by the destructor when still
/// running, and by the kernel when the test's thread dies. The destructor also looks whether what
/// fleetpub printed is as its schemas say (ExpectDescribed).
class Process {
 public:
  static constexpr std::chrono::seconds kPatience{60 * kSlowness};

  /// Starts it. Throws std::runtime_error when there is no such program.
  explicit Process(Command command);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// All that it wrote so far.
  [[nodiscard]] std::string Output() const;
  [[nodiscard]] std::string Errors() const;

  /// To its standard input.
  void Write(std::string_view text) const;
  void CloseInput();

  void Signal(int number = SIGTERM) const;
  /// The exit code, or 128 + the signal that ended it; nothing when it still runs then.
  [[nodiscard]] std::optional<int> Wait(std::chrono::milliseconds patience = kPatience);
  /// The most memory that it had at once, once it has ended.
  [[nodiscard]] std::size_t peak_mib() const { return peak_mib_; }
  [[nodiscard]] bool Running() { return !Wait(std::chrono::milliseconds(0)); }
  /// Whether the text came in time (false also when it ended without). In Output() or Errors().
  [[nodiscard]] bool AwaitOutput(std::string_view text,
                                 std::chrono::milliseconds patience = kPatience);
  [[nodiscard]] bool AwaitErrors(std::string_view text,
                                 std::chrono::milliseconds patience = kPatience);

 private:
  [[nodiscard]] bool AwaitText(int descriptor, std::string_view text,
                               std::chrono::milliseconds patience);
  void Launch(const Command& command, int input);

  std::vector<std::string> arguments_;
  pid_t pid_ = -1;
  int process_ = -1;  // a pidfd
  int input_ = -1;
  int output_ = -1;
  int errors_ = -1;
  std::optional<int> exit_code_;
  std::size_t peak_mib_ = 0;
};

struct Finished {
  int exit_code = -1;  ///< as of Process::Wait; -1: had to be killed
  std::string output;
  std::string errors;
  std::size_t peak_mib = 0;  ///< as of Process::peak_mib
};

/// Runs it to its end.
[[nodiscard]] Finished Run(Command command,
                           std::chrono::milliseconds patience = Process::kPatience);

}  // namespace fleetpub::testing
