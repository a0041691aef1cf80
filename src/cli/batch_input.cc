#include "cli/batch_input.h"

#include <fmt/format.h>
#include <poll.h>

#include <utility>

#include "base/json.h"

namespace fleetpub::cli {
namespace {

using dispatch::Command;
using dispatch::Verdict;

constexpr std::size_t kLongestLine = base::JsonLimits{}.bytes;
// More text than that is not read before what there is has left.
constexpr std::size_t kGroupBytes = std::size_t{1024} * 1024;

}  // namespace

void BatchResults::Show(const dispatch::Report& report) {
  const ExitCode code = CodeOf(report);
  worst_ = Worse(worst_, code);
  output_.Line("{" + report.reference + R"(,"exitCode":)" + std::to_string(static_cast<int>(code)) +
               ReportJson(report).replace(0, 1, ","));
}

void BatchResults::ShowBad(std::string reference, const LineOrigin& origin, const Error& error) {
  dispatch::Report report;
  report.reference = std::move(reference);
  report.target = origin.target;
  report.message = error.message;
  // Whatever is wrong with a line, the line is wrong; unless it could not even be read.
  const bool is_line = error.kind == ErrorKind::kInvalid || error.kind == ErrorKind::kUsage;
  report.verdict = is_line ? Verdict::kInvalid : Verdict::kError;
  report.error = is_line ? ErrorKind::kInvalid : error.kind;
  Show(report);
}

BatchInput::BatchInput(base::LineReader reader, LineDefaults defaults, AfterBadLine after_bad_line,
                       const Context& context, BatchResults& results)
    : reader_(std::move(reader)),
      after_bad_line_(after_bad_line),
      output_(context.output),
      results_(results),
      parser_(std::move(defaults), context.options.schema_directory) {}

std::vector<Command> BatchInput::Take(std::size_t most) {
  std::vector<Command> commands;
  std::size_t bytes = 0;
  while (!ended_ && commands.size() < most && bytes < kGroupBytes && Ready()) {
    const auto line = reader_.Next(kLongestLine);
    if (line && !*line) {
      ended_ = true;
      break;
    }
    ++number_;
    if (line) bytes += (*line)->size();
    if (!TakeLine(line, commands) && after_bad_line_ == AfterBadLine::kPause) break;
  }
  return commands;
}

void BatchInput::Await() const {
  pollfd arrived{reader_.descriptor(), POLLIN, 0};
  poll(&arrived, 1, -1);
}

bool BatchInput::Ready() { return reader_.Ready(kLongestLine); }

// False: it was bad.
bool BatchInput::TakeLine(const Result<std::optional<std::string_view>>& line,
                          std::vector<Command>& commands) {
  LineOrigin origin;
  if (!line) {
    results_.ShowBad(ReferenceOf(origin), origin, line.error());
    return false;
  }
  if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) return true;
  auto parsed = parser_.Parse(**line, origin);
  if (!parsed) {
    results_.ShowBad(ReferenceOf(origin), origin, parsed.error());
    return false;
  }
  for (const std::string& warning : parsed->warnings) {
    output_.Warn(fmt::format("line {}: {}", number_, warning));
  }
  for (Command& command : parsed->commands) {
    command.reference = ReferenceOf(origin);
    commands.push_back(std::move(command));
  }
  return true;
}

std::string BatchInput::ReferenceOf(const LineOrigin& origin) const {
  return origin.id.empty() ? fmt::format(R"("line":{})", number_)
                           : fmt::format(R"("line":{},"id":{})", number_, origin.id);
}

}  // namespace fleetpub::cli
