#include "support/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "support/described_output.h"

extern char** environ;

namespace fleetpub::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kGlance{2};  // between two looks at growing output

int Checked(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

int Memory(const char* name) { return Checked(memfd_create(name, MFD_CLOEXEC), "memfd_create"); }

std::string Content(int descriptor) {
  std::string text;
  std::array<char, 65'536> block;
  while (true) {
    const ssize_t got =
        pread(descriptor, block.data(), block.size(), static_cast<off_t>(text.size()));
    if (got <= 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
  }
}

void WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // the child does not listen any more
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Environment(const Command& command) {
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry) entries.emplace_back(*entry);
  for (const auto& [name, value] : command.environment) {
    const std::string start = name + "=";
    std::erase_if(entries, [&start](const std::string& entry) { return entry.starts_with(start); });
    if (value) entries.push_back(start + *value);
  }
  return entries;
}

int LeftUntil(steady_clock::time_point deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
  return static_cast<int>(std::max<milliseconds::rep>(left.count(), 0));
}

}  // namespace

Process::Process(Command command) : arguments_(command.arguments) {
  // A write to a child that has gone is no reason to die.
  static const auto ignored = signal(SIGPIPE, SIG_IGN);
  static_cast<void>(ignored);
  output_ = Memory("stdout");
  errors_ = Memory("stderr");
  int input = -1;
  if (command.input) {
    input = Memory("stdin");
    WriteAll(input, *command.input);
    lseek(input, 0, SEEK_SET);
  } else {
    std::array<int, 2> ends{};
    Checked(pipe2(ends.data(), O_CLOEXEC), "pipe");
    input = ends[0];
    input_ = ends[1];
  }
  Launch(command, input);
  close(input);
}

void Process::Launch(const Command& command, int input) {
  std::vector<std::string> arguments = command.arguments;
  std::vector<std::string> entries = Environment(command);
  const std::vector<char*> argv = Pointers(arguments);
  const std::vector<char*> envp = Pointers(entries);
  std::array<int, 2> failure{};
  Checked(pipe2(failure.data(), O_CLOEXEC), "pipe");
  const pid_t parent = getpid();
  pid_ = Checked(fork(), "fork");
  if (pid_ == 0) {  // only what is safe after fork() in a program with threads
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);
    signal(SIGPIPE, SIG_DFL);
    dup2(input, 0);
    dup2(output_, 1);
    dup2(errors_, 2);
    if (command.folder.empty() || chdir(command.folder.c_str()) == 0) {
      execvpe(argv[0], argv.data(), envp.data());
    }
    const int error = errno;
    static_cast<void>(!write(failure[1], &error, sizeof error));
    _exit(127);
  }
  close(failure[1]);
  int error = 0;
  const bool failed = read(failure[0], &error, sizeof error) == sizeof error;
  close(failure[0]);
  process_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (failed) {
    waitpid(pid_, nullptr, 0);
    throw std::runtime_error("cannot start " + command.arguments.front() + ": " +
                             std::generic_category().message(error));
  }
}

Process::~Process() {
  if (Running()) {
    Signal(SIGKILL);
    static_cast<void>(Wait());
  }
  ExpectDescribed(arguments_, Output());
  for (const int descriptor : {process_, input_, output_, errors_}) {
    if (descriptor >= 0) close(descriptor);
  }
}

std::string Process::Output() const { return Content(output_); }
std::string Process::Errors() const { return Content(errors_); }

void Process::Write(std::string_view text) const { WriteAll(input_, text); }

void Process::CloseInput() {
  if (input_ >= 0) close(input_);
  input_ = -1;
}

void Process::Signal(int number) const {
  if (!exit_code_) kill(pid_, number);
}

std::optional<int> Process::Wait(milliseconds patience) {
  if (exit_code_) return exit_code_;
  const auto deadline = steady_clock::now() + patience;
  while (true) {
    int status = 0;
    rusage usage{};
    const pid_t ended = wait4(pid_, &status, WNOHANG, &usage);
    if (ended == pid_) {
      peak_mib_ = static_cast<std::size_t>(usage.ru_maxrss) / 1024;
      exit_code_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
      return exit_code_;
    }
    if (steady_clock::now() >= deadline) return std::nullopt;
    pollfd waiting{process_, POLLIN, 0};
    poll(&waiting, 1, LeftUntil(deadline));
  }
}

bool Process::AwaitOutput(std::string_view text, milliseconds patience) {
  return AwaitText(output_, text, patience);
}

bool Process::AwaitErrors(std::string_view text, milliseconds patience) {
  return AwaitText(errors_, text, patience);
}

bool Process::AwaitText(int descriptor, std::string_view text, milliseconds patience) {
  const auto deadline = steady_clock::now() + patience;
  while (true) {
    const bool over = !Running() || steady_clock::now() >= deadline;
    if (Content(descriptor).find(text) != std::string::npos) return true;
    if (over) return false;
    static_cast<void>(Wait(kGlance));
  }
}

Finished Run(Command command, milliseconds patience) {
  if (!command.input) command.input = "";
  Process process(std::move(command));
  const auto exit_code = process.Wait(patience);
  if (!exit_code) {
    process.Signal(SIGKILL);
    static_cast<void>(process.Wait());
  }
  return {exit_code.value_or(-1), process.Output(), process.Errors(), process.peak_mib()};
}

}  // namespace fleetpub::testing
