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

#include "base/json.h"
#include "base/local_time.h"
#include "base/text.h"
#include "base/time.h"
#include "base/width.h"

namespace fleetpub::cli {
namespace {

using message::CommandStatus;
using message::Report;

std::atomic<bool> g_has_passing = false;
int g_why_unwritten = 0;  // what first kept standard output from being written

void Remember(bool is_written) {
  if (!is_written && g_why_unwritten == 0) g_why_unwritten = errno;
}

void ClearPassingLine() {
  if (g_has_passing.exchange(false)) std::fputs("\r\x1b[K", stderr);
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

Tone ChooseTone(const Report& report) {
  if (report.error) return Tone::kBad;
  return report.status == CommandStatus::kDryRun ? Tone::kPlain : Tone::kGood;
}

}  // namespace

void Print(std::FILE* stream, std::string_view text) {
  ClearPassingLine();
  const bool is_written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  if (stream == stdout) Remember(is_written);
}

std::size_t TerminalWidth(int descriptor) {
  winsize size{};
  const bool is_known = ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : std::numeric_limits<std::size_t>::max();
}

std::size_t TerminalHeight(int descriptor) {
  winsize size{};
  const bool is_known = ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_row > 0;
  return is_known ? size.ws_row : 24;
}

Output::Output(Settings settings)
    : settings_(std::move(settings)), colour_(WantsColour(STDOUT_FILENO)) {}

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
  if (!settings_.quiet) Line(text);
}

void Output::Warn(std::string_view text) {
  if (!settings_.quiet) Print(stderr, fmt::format("fleetpub: warning: {}\n", text));
}

void Output::Info(std::string_view text) {
  if (!settings_.quiet) Print(stderr, fmt::format("fleetpub: {}\n", text));
}

void Output::Debug(std::string_view text) {
  if (settings_.verbose) Print(stderr, fmt::format("fleetpub: {}\n", text));
}

void Output::Trace(std::string_view line) {
  Print(stderr, fmt::format("mqtt: {}\n", base::Printable(line)));
}

void Output::PrintError(const Error& error) {
  Print(stderr, fmt::format("fleetpub: error: {}\n", base::WithLocalTimes(error.message)));
  if (settings_.verbose && !error.detail.empty()) {
    Print(stderr, fmt::format("fleetpub: detail: {}\n", base::Printable(error.detail)));
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
  std::fputs(fmt::format("\r\x1b[K{}", base::CutTo(width, text)).c_str(), stderr);
  std::fflush(stderr);
  g_has_passing = true;
}

void Output::ClearPassing() { ClearPassingLine(); }

bool Output::HasPassing() { return g_has_passing; }

std::string Output::Toned(Tone tone, std::string_view text) const {
  if (!colour_ || tone == Tone::kPlain) return std::string(text);
  const std::string_view code = tone == Tone::kGood ? "32" : tone == Tone::kBad ? "1;31" : "2";
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
  if (report.header_id) line += fmt::format("  headerId {}", *report.header_id);
  if (report.elapsed.count() > 0) line += "  " + base::FormatElapsed(report.elapsed);
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
