#include "base/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>

namespace fleetpub::base {
namespace {

std::string ReadFromBegin(int memory) {
  std::string text;
  const off_t size = lseek(memory, 0, SEEK_END);
  if (size <= 0) return text;
  text.resize(static_cast<std::size_t>(size));
  const ssize_t count = pread(memory, text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  return text;
}

// With O_APPEND: whoever looks at its size moves the offset that the child shares.
int OpenMemory() {
  const int memory = memfd_create("fleetpub", MFD_CLOEXEC);
  if (memory >= 0) fcntl(memory, F_SETFL, O_APPEND);
  return memory;
}

std::vector<std::string> MakeEnvironment(const ChildProcess::Command& command) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const bool is_replaced = std::any_of(
        command.environment.begin(), command.environment.end(), [&](const auto& replacement) {
          return text.substr(0, text.find('=')) == replacement.first;
        });
    if (!is_replaced) variables.emplace_back(text);
  }
  for (const auto& [name, value] : command.environment) {
    if (!value.empty()) variables.push_back(fmt::format("{}={}", name, value));
  }
  return variables;
}

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Between fork and exec, where only what is safe in a signal handler may be called.
[[noreturn]] void Become(char* const* arguments, char* const* environment, int input, int output,
                         int errors, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  execve(arguments[0], arguments, environment);
  _exit(127);
}

}  // namespace

void KeepEndsOfChildren() { std::signal(SIGCHLD, SIG_DFL); }

Result<std::unique_ptr<ChildProcess>> ChildProcess::Start(const Command& command) {
  std::unique_ptr<ChildProcess> child(new ChildProcess);
  const int input = memfd_create("fleetpub", MFD_CLOEXEC);
  child->output_ = OpenMemory();
  child->errors_ = OpenMemory();
  const auto size = static_cast<ssize_t>(command.input.size());
  const bool is_ready = input >= 0 && child->output_ >= 0 && child->errors_ >= 0 &&
                        write(input, command.input.data(), command.input.size()) == size &&
                        lseek(input, 0, SEEK_SET) == 0;
  if (is_ready) {
    std::vector<std::string> arguments = command.arguments;
    std::vector<std::string> variables = MakeEnvironment(command);
    const auto argument_pointers = Pointers(arguments);
    const auto variable_pointers = Pointers(variables);
    KeepEndsOfChildren();
    const pid_t parent = getpid();
    child->pid_ = fork();
    if (child->pid_ == 0) {
      Become(argument_pointers.data(), variable_pointers.data(), input, child->output_,
             child->errors_, parent);
    }
  }
  const int reason = errno;
  if (input >= 0) close(input);
  if (child->pid_ > 0) return child;
  return Fail(ErrorKind::kUnexpected,
              fmt::format("cannot start {}: {}", command.arguments.front(), std::strerror(reason)));
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0 && !Poll()) {
    Terminate();
    if (!Wait(std::chrono::seconds(5))) {
      kill(-pid_, SIGKILL);
      (void)Wait(std::chrono::seconds(5));
    }
  }
  for (const int memory : {output_, errors_}) {
    if (memory >= 0) close(memory);
  }
}

std::optional<int> ChildProcess::Poll() {
  int status = 0;
  if (!exit_code_ && waitpid(pid_, &status, WNOHANG) == pid_) {
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return exit_code_;
}

void ChildProcess::Terminate() {
  if (!exit_code_ && !std::exchange(is_terminated_, true)) kill(pid_, SIGTERM);
}

bool ChildProcess::Wait(std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!Poll()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

std::string ChildProcess::Output() const { return ReadFromBegin(output_); }
std::string ChildProcess::Errors() const { return ReadFromBegin(errors_); }

}  // namespace fleetpub::base
