#include "cli/output/screen.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace fleetpub::cli {
namespace {

// Alternate screen, no cursor, no line wrapping (a character may be wider than we think); and back.
constexpr std::string_view kEnterScreen = "\x1b[?1049h\x1b[?25l\x1b[?7l";
constexpr std::string_view kLeaveScreen = "\x1b[?7h\x1b[?25h\x1b[?1049l";

constexpr std::array kCrashes = {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};

// What the signal handlers know. All that they call is safe there (signal-safety(7)).
volatile std::sig_atomic_t g_active = 0;
volatile std::sig_atomic_t g_disturbed = 0;
bool g_has_keys = false;
termios g_normal{};
termios g_keys{};

void Write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno != EINTR) return;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Enter() {
  g_active = 1;  // first: a signal that comes now must find something to restore
  if (g_has_keys) tcsetattr(STDIN_FILENO, TCSADRAIN, &g_keys);
  Write(kEnterScreen);
}

void Leave() {
  if (g_active == 0) return;
  g_active = 0;
  Write(kLeaveScreen);
  // Not TCSADRAIN, which would wait for a person who has stopped the output with Ctrl-S.
  if (g_has_keys) tcsetattr(STDIN_FILENO, TCSANOW, &g_normal);
}

void LeaveAndExit(int /*signal*/) {
  Leave();
  _exit(0);
}

// Ends as the signal would have without us.
void EndBySignal(int signal) {
  Leave();
  _exit(128 + signal);
}

// Our own fault: the terminal is given back, then it takes its course.
void Crash(int signal) {
  Leave();
  std::signal(signal, SIG_DFL);
  raise(signal);
}

void Stop(int /*signal*/) {
  const int error = errno;
  Leave();
  raise(SIGSTOP);
  Enter();
  g_disturbed = 1;
  errno = error;
}

void Disturb(int /*signal*/) { g_disturbed = 1; }

void Handle(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigfillset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

// kNoKey: none came in time.
int ReadByte(int wait_ms) {
  pollfd keyboard{STDIN_FILENO, POLLIN, 0};
  unsigned char byte = 0;
  const bool comes =
      g_has_keys && poll(&keyboard, 1, wait_ms) > 0 && (keyboard.revents & POLLIN) != 0;
  return comes && read(STDIN_FILENO, &byte, 1) == 1 ? byte : static_cast<int>(kNoKey);
}

}  // namespace

void EndQuietlyOnSignals() {
  Handle(SIGINT, LeaveAndExit);
  Handle(SIGTERM, LeaveAndExit);
}

bool Screen::IsPossible() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDOUT_FILENO) == 1 && terminal != nullptr && *terminal != '\0' &&
         std::string_view(terminal) != "dumb";
}

Screen::Screen() {
  g_has_keys = isatty(STDIN_FILENO) == 1 && tcgetattr(STDIN_FILENO, &g_normal) == 0;
  g_keys = g_normal;
  g_keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  EndQuietlyOnSignals();
  Handle(SIGHUP, EndBySignal);
  Handle(SIGQUIT, EndBySignal);
  Handle(SIGTSTP, Stop);
  Handle(SIGWINCH, Disturb);
  for (const int signal : kCrashes) Handle(signal, Crash);
  Enter();
}

Screen::~Screen() {
  Leave();
  for (const int signal : {SIGHUP, SIGQUIT, SIGTSTP, SIGWINCH}) Handle(signal, SIG_DFL);
  for (const int signal : kCrashes) Handle(signal, SIG_DFL);
}

Screen::Size Screen::size() {
  winsize size{};
  const bool is_known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0;
  return is_known ? Size{size.ws_row, size.ws_col} : Size{24, 80};
}

bool Screen::WasDisturbed() {
  const bool disturbed = g_disturbed != 0;
  g_disturbed = 0;
  return disturbed;
}

void Screen::Draw(std::span<const std::string> lines) {
  std::string frame = "\x1b[H";
  for (const std::string& line : lines) {
    frame += line;
    frame += "\x1b[K";
    if (&line != &lines.back()) frame += "\r\n";
  }
  Write(frame + "\x1b[J");
}

int ReadEscapeSequence(std::string_view sequence) {
  // As terminals send them, in cursor and in application mode, and as tmux and screen do.
  static constexpr std::pair<std::string_view, int> kSequences[] = {
      {"[A", kUp},        {"OA", kUp},   {"[B", kDown}, {"OB", kDown},  {"[5~", kPageUp},
      {"[6~", kPageDown}, {"[H", kHome}, {"OH", kHome}, {"[1~", kHome}, {"[7~", kHome},
      {"[F", kEnd},       {"OF", kEnd},  {"[4~", kEnd}, {"[8~", kEnd}};
  for (const auto& [text, key] : kSequences) {
    if (text == sequence) return key;
  }
  return kOtherKey;
}

int Screen::ReadKey() {
  // A slow line may cut a sequence in two.
  constexpr int kRest = 25;  // ms
  const int key = ReadByte(0);
  if (key == '\r') return kEnter;
  if (key == '\b') return kBackspace;
  if (key != kEscape) return key;
  std::string sequence;
  for (int next = ReadByte(kRest); next != kNoKey; next = ReadByte(kRest)) {
    sequence += static_cast<char>(next);
    const bool is_last = sequence.size() > 1 && next >= '@' && next <= '~';
    if (is_last || sequence.size() > 16) break;
    if (sequence.size() == 1 && next != '[' && next != 'O') break;
  }
  return sequence.empty() ? kEscape : ReadEscapeSequence(sequence);
}

}  // namespace fleetpub::cli
