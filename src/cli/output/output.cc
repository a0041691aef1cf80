#include "cli/output/output.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>

#include "base/json.h"
#include "base/local_time.h"
#include "base/text.h"
#include "base/time.h"
#include "base/width.h"
#include "cli/output/waiting_line.h"

namespace fleetpub::cli {
namespace {

using message::CommandStatus;
using message::Report;
using std::chrono::steady_clock;

std::atomic<int> g_passing = 0;  // lines that pass
std::mutex g_terminal;           // whoever draws or replaces them
int g_why_unwritten = 0;         // what first kept standard output from being written

void Remember(bool is_written) {
  if (!is_written && g_why_unwritten == 0) g_why_unwritten = errno;
}

// What takes the cursor back to where they begin, with nothing behind it.
std::string TakeBackPassing() {
  const int lines = g_passing.exchange(0);
  if (lines == 0) return "";
  return lines == 1 ? "\r\x1b[K" : fmt::format("\x1b[{}A\r\x1b[J", lines - 1);
}

void ClearPassingLine() {
  if (g_passing != 0) std::fputs(TakeBackPassing().c_str(), stderr);
}

bool WantsColour(int descriptor) {
  const char* no_colour = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  if (terminal != nullptr && std::string_view(terminal) == "dumb") return false;
  return isatty(descriptor) == 1;
}

std::string FormatTypes(const Report& report) {
  std::vector<std::string> types;
  for (const auto& action : report.actions) types.push_back(base::Printable(action.type));
  return base::Join(types, ",");
}

// In whole milliseconds.
std::string FormatTook(std::chrono::nanoseconds elapsed) {
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(elapsed);
  return ms < std::chrono::seconds(1) ? fmt::format("{} ms", ms.count()) : base::FormatElapsed(ms);
}

Tone ChooseTone(const Report& report) {
  if (report.error) return Tone::kBad;
  return report.status == CommandStatus::kDryRun ? Tone::kPlain : Tone::kGood;
}

}  // namespace

void Print(std::FILE* stream, std::string_view text) {
  const std::scoped_lock lock(g_terminal);
  ClearPassingLine();
  const bool is_written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  if (stream == stdout) Remember(is_written);
}

std::size_t TerminalWidth(int descriptor) {
  winsize size{};
  const bool is_known = ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : std::numeric_limits<std::size_t>::max();
}

std::string WrappedFor(int descriptor, std::string_view text) {
  constexpr std::size_t kIndent = 4;
  const std::size_t width = TerminalWidth(descriptor);
  if (text.find('\n') != std::string_view::npos) return std::string(text);
  return width < 2 * kIndent ? std::string(text) : base::Wrapped(width, kIndent, text);
}

Output::Output(Settings settings)
    : settings_(std::move(settings)),
      colour_(settings_.color == "always" ||
              (settings_.color == "auto" && WantsColour(STDOUT_FILENO))) {}

Output::~Output() = default;

void Output::Line(std::string_view text) {
  if (json()) return JsonLine(text);
  Print(stdout, text);
  Print(stdout, "\n");
}

void Output::JsonLine(std::string_view json) {
  if (const auto lines = settings_.records.Render(json)) {
    has_lines_ = has_lines_ || !lines->empty();
    return Print(stdout, *lines);
  }
  has_lines_ = true;
  Print(stdout, base::ShownJson(json));
  Print(stdout, "\n");
}

void Output::PeopleLine(std::string_view text) {
  if (!settings_.quiet) Line(WrappedFor(STDOUT_FILENO, text));
}

void Output::Important(std::string_view text) {
  Print(stderr,
        WrappedFor(STDERR_FILENO, fmt::format("fleetpub: {}", base::WithLocalTimes(text))) + "\n");
}

void Output::Warn(std::string_view text) {
  if (!settings_.quiet) Important(fmt::format("warning: {}", text));
}

void Output::Info(std::string_view text) {
  if (!settings_.quiet) Important(text);
}

void Output::Debug(std::string_view text) {
  if (settings_.verbose) Important(text);
}

void Output::Wait(std::string_view what, steady_clock::time_point limit, std::string_view hint) {
  if (waiting_ == nullptr) {
    if (what.empty() || !CanPass()) return;
    waiting_ = std::make_unique<WaitingLine>(*this);
  }
  waiting_->Set(what, limit, hint);
}

void Output::Trace(std::string_view line) {
  Print(stderr, fmt::format("mqtt: {}\n", base::Printable(line)));
}

void Output::PrintError(const Error& error) {
  Important(fmt::format("error: {}", error.message));
  if (settings_.verbose && !error.detail.empty()) {
    Important(fmt::format("detail: {}", base::Printable(error.detail)));
  }
}

void Output::PrintFinalError(const Error& error, ExitCode code) {
  PrintError(error);
  if (!json() || has_lines_) return;
  Line(fmt::format(R"({{"error":{{"exitCode":{},"message":{}}}}})", static_cast<int>(code),
                   base::JsonString(error.message)));
}

bool Output::CanPass() const {
  struct stat out {};
  const bool is_pipe =
      fstat(STDOUT_FILENO, &out) == 0 && (S_ISFIFO(out.st_mode) || S_ISSOCK(out.st_mode));
  return !settings_.quiet && !is_pipe && isatty(STDERR_FILENO) == 1;
}

void Output::Pass(std::string_view text) {
  // The last column stays empty: some terminals go to the next line at once.
  const std::size_t width = TerminalWidth(STDERR_FILENO) - 1;
  const std::string line(base::CutTo(width, text));
  Pass(std::span(&line, 1));
}

void Output::Pass(std::span<const std::string> lines) {
  const std::scoped_lock lock(g_terminal);
  std::fputs(("\r" + TakeBackPassing() + base::Join(lines, "\x1b[K\r\n") + "\x1b[K").c_str(),
             stderr);
  std::fflush(stderr);
  g_passing = static_cast<int>(lines.size());
}

void Output::ClearPassing() {
  const std::scoped_lock lock(g_terminal);
  ClearPassingLine();
}

bool Output::HasPassing() { return g_passing != 0; }

std::string Output::Toned(Tone tone, std::string_view text) const {
  if (!colour_ || tone == Tone::kPlain) return std::string(text);
  const std::string_view code = tone == Tone::kGood   ? "32"
                                : tone == Tone::kWarn ? "33"
                                : tone == Tone::kBad  ? "1;31"
                                                      : "2";
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

void Output::FlushNow() { Remember(std::fflush(stdout) == 0); }

Status Output::Flush() {
  FlushNow();
  if (g_why_unwritten == 0 && std::ferror(stdout) == 0) return {};
  // Who reads has seen enough (`| head`); what was sent is another matter.
  pollfd reader{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  const bool is_gone = poll(&reader, 1, 0) == 1 && (reader.revents & POLLERR) != 0;
  if (is_gone && !something_was_sent()) return {};
  return Fail(ErrorKind::kLedger, fmt::format("the results could not be written to standard "
                                              "output: {}",
                                              std::strerror(g_why_unwritten)));
}

std::string ReportText(const Report& report, std::size_t target_width, const Output& output) {
  std::string line =
      fmt::format("{}  {}  {}", base::Padded(target_width, base::Printable(report.target)),
                  FormatTypes(report), output.Toned(ChooseTone(report), GetName(report.status)));
  if (report.elapsed.count() > 0) line += "  " + FormatTook(report.elapsed);
  if (report.version_assumed) line += fmt::format("  {} (assumed)", report.version);
  if (!report.message.empty()) line += "  " + base::WithLocalTimes(report.message);
  return line;
}

std::string ReportJson(const Report& report) {
  using base::JsonString;
  std::string json = R"({"target":)" + JsonString(report.target);
  const auto add = [&json](std::string_view name, std::string_view value) {
    ((((json += ",\"") += name) += "\":") += value);
  };
  add("protocol", JsonString(report.protocol));
  add("version", JsonString(report.version));
  add("topic", JsonString(report.topic));
  std::string actions;
  for (const auto& [type, id] : report.actions) {
    actions += (actions.empty() ? R"({"type":)" : R"(,{"type":)") + JsonString(type);
    actions += R"(,"id":)" + JsonString(id) + "}";
  }
  add("actions", "[" + actions + "]");
  if (report.version_assumed) add("versionAssumed", "true");
  if (report.header_id) add("headerId", std::to_string(*report.header_id));
  add("status", JsonString(GetName(report.status)));
  add("elapsedMs", fmt::format("{:.3f}", static_cast<double>(report.elapsed.count()) / 1e6));
  if (!report.message.empty()) add("message", JsonString(report.message));
  if (report.status == CommandStatus::kDryRun) add("payload", report.payload);
  return json + "}";
}

}  // namespace fleetpub::cli
