// A real terminal emulator (tmux), for what people see.
#pragma once

#include <string>
#include <vector>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// A terminal of a given size in which one shell command runs; both end with this object.
class Terminal {
 public:
  Terminal(const std::string& line, int columns, int rows);
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  /// A key as tmux names it: `q`, `C-c`, `Tab`.
  void Press(const std::string& key);
  void Type(const std::string& text);
  void Resize(int columns, int rows);
  [[nodiscard]] std::string Shown();
  /// The same with its colours, as escape sequences.
  [[nodiscard]] std::string ShownInColour();
  /// Columns that the text takes here: this terminal's word for it.
  [[nodiscard]] std::size_t MeasureWidth(const std::string& text);
  /// Two digits, 1 or 0: the alternate screen is on, the cursor is shown.
  [[nodiscard]] std::string Flags();
  /// Whether the text is shown in time; the test fails when it is not.
  bool Await(const std::string& text);

 private:
  std::string Tmux(std::vector<std::string> arguments);

  TemporaryFolder folder_;
};

/// The command with its environment as a line for a shell.
[[nodiscard]] std::string ShellLine(const Command& command);

}  // namespace fleetpub::testing
