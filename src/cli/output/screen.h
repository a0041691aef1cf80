// The terminal as a screen that is redrawn in place.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace fleetpub::cli {

/// A key: the byte that it sends, or one of these.
enum Key : int {
  kNoKey = 0,
  kOtherKey = -1,  ///< a sequence that means nothing here
  kEnter = 10,
  kEscape = 27,
  kBackspace = 127,
  kUp = 256,
  kDown,
  kPageUp,
  kPageDown,
  kHome,
  kEnd
};

/// The key that an escape sequence without its ESC means: `[A`.
[[nodiscard]] int ReadEscapeSequence(std::string_view sequence);

/// From now on SIGINT and SIGTERM end the process at once, with exit code 0: the normal end of a
/// command that watches. When there is a Screen, the terminal is restored first.
void EndQuietlyOnSignals();

/// Standard output's terminal while this lives: alternate screen, no cursor, keys not echoed.
/// Restored by the destructor and before any signal's end; Ctrl-Z leaves the screen and `fg` comes
/// back to it. One at a time.
class Screen {
 public:
  /// Whether standard output is a terminal that can be redrawn.
  [[nodiscard]] static bool IsPossible();

  Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;
  ~Screen();

  struct Size {
    std::size_t rows;
    std::size_t columns;
  };
  [[nodiscard]] static Size size();

  /// Whether the size or the content has changed since the last call without our doing.
  [[nodiscard]] static bool WasDisturbed();

  /// Replaces what is shown. Lines are printable but for colours, and no wider than the screen.
  void Draw(std::span<const std::string> lines);

  /// The next key that was pressed, or kNoKey. Waits only for the rest of an escape sequence.
  [[nodiscard]] static int ReadKey();
};

}  // namespace fleetpub::cli
