#include "cli/options/password_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>

#include "base/child_process.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/options/password.h"
#include "cli/output/interrupt.h"
#include "mqtt/descriptor.h"

namespace fleetpub::cli {
namespace {

using mqtt::Descriptor;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

// A program in the background may not ask a person at the terminal.
bool HoldsTerminal() {
  const Descriptor terminal(open("/dev/tty", O_RDWR | O_CLOEXEC));
  return terminal.get() >= 0 && tcgetpgrp(terminal.get()) == getpgrp();
}

// A program that runs, with all that it starts where no person is asked: it gets a process group
// of its own. Killed with this object if it still runs then, and ended with this process.
class Program {
 public:
  Program() = default;
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    EndWithUs(0);
    if (pid_ <= 0) return;
    kill(whole(), SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  /// 0, or why it cannot be started.
  int Start(const std::vector<std::string>& arguments, int output) {
    std::vector<char*> words;
    words.reserve(arguments.size() + 1);
    for (const std::string& argument : arguments) {
      words.push_back(const_cast<char*>(argument.c_str()));
    }
    words.push_back(nullptr);
    base::KeepEndsOfChildren();
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t ignored_here;
    sigemptyset(&ignored_here);
    posix_spawnattr_setsigmask(&attributes, &ignored_here);
    sigaddset(&ignored_here, SIGPIPE);
    sigaddset(&ignored_here, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes, &ignored_here);
    posix_spawnattr_setflags(&attributes,
                             static_cast<short>(POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK |
                                                (has_group_ ? POSIX_SPAWN_SETPGROUP : 0)));
    // A signal that ends us waits until we know whom it is to end, too.
    sigset_t ending;
    sigset_t before;
    sigemptyset(&ending);
    sigaddset(&ending, SIGINT);
    sigaddset(&ending, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &ending, &before);
    const int error =
        posix_spawnp(&pid_, words.front(), &files, &attributes, words.data(), environ);
    if (error != 0) pid_ = -1;
    if (error == 0) EndWithUs(whole());
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
  }

  /// Its status as of waitpid, once it has ended.
  std::optional<int> Ended() {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
    EndWithUs(0);
    pid_ = -1;
    return status;
  }

 private:
  [[nodiscard]] pid_t whole() const { return has_group_ ? -pid_ : pid_; }

  const bool has_group_ = !HoldsTerminal();
  pid_t pid_ = -1;
};

// What a pipe brings, of which one byte more than a password and its line's end is kept.
class Collector {
 public:
  explicit Collector(int descriptor) : descriptor_(descriptor) {}
  Collector(const Collector&) = delete;
  Collector& operator=(const Collector&) = delete;
  ~Collector() { explicit_bzero(text_.data(), text_.size()); }

  enum class Came { kSome, kNothing, kEnd };
  /// What comes within this time.
  Came Take(milliseconds patience) {
    pollfd pipe{.fd = descriptor_, .events = POLLIN, .revents = 0};
    if (poll(&pipe, 1, static_cast<int>(patience.count())) <= 0) return Came::kNothing;
    std::array<char, 4096> chunk{};
    const ssize_t count = read(descriptor_, chunk.data(), chunk.size());
    if (count > 0) {
      text_.append(chunk.data(), std::min(static_cast<std::size_t>(count), room()));
      explicit_bzero(chunk.data(), chunk.size());
      return Came::kSome;
    }
    return count < 0 && (errno == EINTR || errno == EAGAIN) ? Came::kNothing : Came::kEnd;
  }

  [[nodiscard]] std::size_t room() const { return kLongestPassword + 3 - text_.size(); }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  int descriptor_;
  std::string text_;
};

std::string DescribeEnd(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was ended by signal {}", WTERMSIG(status));
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
}

// Nothing: all is well.
std::string_view FindFault(const std::string& password) {
  if (password.empty()) return "printed no password: its first line is empty";
  if (password.find('\0') != std::string::npos) return "printed a NUL byte";
  if (password.size() > kLongestPassword) {
    return "printed a line of more than the 65,535 bytes that MQTT can carry";
  }
  return {};
}

}  // namespace

Result<std::string> RunPasswordCommand(const std::vector<std::string>& arguments,
                                       std::string_view origin, milliseconds limit) {
  const auto fail = [&](std::string_view what) {
    return Fail(ErrorKind::kLedger,
                fmt::format("password_command ({}): {} {}: try it in a shell, or give the password "
                            "with --password-file",
                            origin, base::Printable(arguments.front()), what));
  };
  const auto deadline = steady_clock::now() + limit;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return fail(std::strerror(errno));
  const Descriptor input(ends[0]);
  Descriptor output(ends[1]);
  fcntl(input.get(), F_SETFL, O_NONBLOCK);
  const InterruptGuard at_once;  // also where somebody waits for an orderly end: nothing has begun
  Program program;
  if (const int error = program.Start(arguments, output.get()); error != 0) {
    return fail(fmt::format("cannot be started: {}", std::strerror(error)));
  }
  output = Descriptor();
  // Its end, not that of its output: a daemon that it leaves behind may hold that open.
  constexpr milliseconds kStep{5};
  Collector collected(input.get());
  bool is_open = true;
  std::optional<int> status;
  while (!(status = program.Ended())) {
    if (steady_clock::now() >= deadline) {
      return fail(fmt::format("has not ended within {}", base::FormatElapsed(limit)));
    }
    if (is_open) {
      is_open = collected.Take(kStep) != Collector::Came::kEnd;
    } else {
      poll(nullptr, 0, 1);
    }
  }
  while (is_open && collected.room() > 0) {
    is_open = collected.Take(milliseconds(0)) == Collector::Came::kSome;
  }
  if (*status != 0) return fail(DescribeEnd(*status));
  std::string password = FirstLine(collected.text());
  if (const auto fault = FindFault(password); !fault.empty()) return fail(fault);
  return password;
}

}  // namespace fleetpub::cli
