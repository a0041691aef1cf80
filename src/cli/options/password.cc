#include "cli/options/password.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <vector>

#include "base/file.h"
#include "cli/options/password_command.h"
#include "cli/output/interrupt.h"
#include "config/config_settings.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kCredential = "fleetpub.password";
constexpr const char* kLedgerCredential = "fleetpub.ledger_password";

constexpr int kEndOrStop[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP};
volatile std::sig_atomic_t g_signal = 0;

// Switches the terminal's echo off while it lives; a signal meanwhile is noted in g_signal, and ends a read.
class SilentTerminal {
 public:
  explicit SilentTerminal(int descriptor) : descriptor_(descriptor) {
    g_signal = 0;
    struct sigaction note {};
    note.sa_handler = [](int signal) { g_signal = signal; };
    for (std::size_t i = 0; i < before_.size(); ++i) sigaction(kEndOrStop[i], &note, &before_[i]);
    if (tcgetattr(descriptor_, &echoing_) != 0) return;
    termios silent = echoing_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    changed_ = tcsetattr(descriptor_, TCSAFLUSH, &silent) == 0;
  }
  SilentTerminal(const SilentTerminal&) = delete;
  SilentTerminal& operator=(const SilentTerminal&) = delete;
  ~SilentTerminal() {
    if (changed_) tcsetattr(descriptor_, TCSAFLUSH, &echoing_);
    for (std::size_t i = 0; i < before_.size(); ++i) {
      sigaction(kEndOrStop[i], &before_[i], nullptr);
    }
  }

 private:
  int descriptor_;
  std::array<struct sigaction, std::size(kEndOrStop)> before_{};
  bool changed_ = false;
  termios echoing_{};
};

std::string ReadLine(int descriptor) {
  std::string line;
  char c = 0;
  while (line.size() < kLongestPassword && read(descriptor, &c, 1) == 1 && c != '\n') line += c;
  return line;
}

Result<std::string> Prompt() {
  const int terminal = open("/dev/tty", O_RDWR | O_CLOEXEC);
  if (terminal < 0) {
    return Fail(
        ErrorKind::kUsage,
        "--ask-password needs a terminal; without one, use --password-file or FLEETPUB_PASSWORD");
  }
  constexpr std::string_view kQuestion = "Password: ";
  std::string password;
  do {
    {
      const SilentTerminal silent(terminal);
      if (write(terminal, kQuestion.data(), kQuestion.size()) > 0) password = ReadLine(terminal);
      if (write(terminal, "\n", 1) != 1) password.clear();
    }
    // Also where somebody waits for an orderly end: nothing has begun. After Ctrl-Z it is asked again.
    const InterruptGuard at_once;
    if (g_signal != 0) raise(g_signal);
  } while (g_signal != 0);
  close(terminal);
  return password;
}

std::optional<std::string> FromEnvironment() {
  const char* value = std::getenv("FLEETPUB_PASSWORD");
  if (value == nullptr) return std::nullopt;
  std::string password = value;
  ForgetVariable("FLEETPUB_PASSWORD");
  return password;
}

std::optional<std::string> SystemdCredential(const char* name) {
  const char* folder = std::getenv("CREDENTIALS_DIRECTORY");
  if (folder == nullptr) return std::nullopt;
  const std::filesystem::path file = std::filesystem::path(folder) / name;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  return file.string();
}

}  // namespace

std::string FirstLine(std::string text) {
  text.resize(std::min(text.find('\n'), text.size()));
  if (text.ends_with('\r')) text.pop_back();
  return text;
}

void ForgetVariable(const char* name) {
  char* const value = std::getenv(name);
  if (value == nullptr) return;
  explicit_bzero(value, std::strlen(value));
  unsetenv(name);
}

std::optional<std::string> FindPasswordCredential() { return SystemdCredential(kCredential); }

bool HasPasswordInEnvironment() {
  return std::getenv("FLEETPUB_PASSWORD") != nullptr || FindPasswordCredential();
}

bool CanOthersRead(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
         (status.st_mode & (S_IRGRP | S_IROTH)) != 0;
}

Result<std::string> ReadSecretFile(const std::string& path, app::Log& log) {
  auto content = base::ReadFile(path, kLongestPassword + 2);
  if (!content) return content;
  if (CanOthersRead(path)) {
    log.Warn(fmt::format("{} can be read by others: chmod 600 {}", path, path));
  }
  return content;
}

Result<std::string> ReadPasswordFile(const std::string& path, app::Log& log) {
  auto content = ReadSecretFile(path, log);
  if (!content) return content;
  return FirstLine(std::move(*content));
}

namespace {

// Each program once in a process, however often it connects: a run may ask a person, or cost a token.
Result<FoundPassword> PrintedPassword(const Context& context) {
  static std::map<std::vector<std::string>, std::string> printed;  // of profiles, each its own
  const std::vector<std::string>& command = context.options.password_command;
  const std::string origin = context.config.Find(config::kPasswordCommand)->Origin();
  auto known = printed.find(command);
  if (known == printed.end()) {
    auto password = RunPasswordCommand(command, origin);
    if (!password) return Fail(std::move(password.error()));
    known = printed.emplace(command, *std::move(password)).first;
  }
  return FoundPassword{known->second, fmt::format("the password of password_command ({})", origin)};
}

}  // namespace

Result<std::optional<std::string>> FindLedgerPassword(app::Log& log) {
  const auto file = SystemdCredential(kLedgerCredential);
  if (!file || std::getenv("PGPASSWORD") != nullptr) return std::optional<std::string>();
  auto password = ReadPasswordFile(*file, log);
  if (!password) return Fail(std::move(password.error()));
  return std::move(*password);
}

Result<FoundPassword> FindPassword(const Context& context, app::Log& log) {
  const GlobalOptions& options = context.options;
  std::optional<std::string> from_environment = FromEnvironment();
  const auto ask = []() -> Result<FoundPassword> {
    auto password = Prompt();
    if (!password) return Fail(std::move(password.error()));
    return FoundPassword{std::move(*password), "a password typed in"};
  };
  if (options.ask_password) return ask();
  std::string file = options.password_file;
  if (file.empty()) {
    if (from_environment) {
      return FoundPassword{std::move(from_environment), "the password of FLEETPUB_PASSWORD"};
    }
    file = FindPasswordCredential().value_or("");
  }
  if (file.empty() && !options.password_command.empty()) return PrintedPassword(context);
  if (file.empty()) {
    const bool is_somebody_there = isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1;
    if (options.is_login_open && is_somebody_there) return ask();
    return FoundPassword{std::nullopt, "no password"};
  }
  auto password = ReadPasswordFile(file, log);
  if (!password) return Fail(std::move(password.error()));
  return FoundPassword{std::move(*password), fmt::format("the password of file {}", file)};
}

}  // namespace fleetpub::cli
