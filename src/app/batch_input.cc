#include "app/batch_input.h"

#include <fmt/format.h>
#include <poll.h>

#include <utility>

#include "base/json.h"

namespace fleetpub::app {
namespace {

using message::CommandStatus;

constexpr std::size_t kLongestLine = base::JsonLimits{}.bytes;
// More text than that is not read before what there is has left.
constexpr std::size_t kGroupBytes = std::size_t{1024} * 1024;

std::string FormatReference(std::size_t line, const LineOrigin& origin) {
  return origin.id.empty() ? fmt::format(R"("line":{})", line)
                           : fmt::format(R"("line":{},"id":{})", line, origin.id);
}

}  // namespace

message::Report BadLineReport(std::string reference, const LineOrigin& origin, const Error& error) {
  message::Report report;
  report.reference = std::move(reference);
  report.target = origin.target;
  report.message = error.message;
  // Whatever is wrong with a line, the line is wrong; unless it could not even be read.
  const bool is_line = error.kind == ErrorKind::kInvalid || error.kind == ErrorKind::kUsage;
  report.status = is_line ? CommandStatus::kInvalid : CommandStatus::kError;
  report.error = is_line ? ErrorKind::kInvalid : error.kind;
  return report;
}

BatchInput::BatchInput(base::LineReader reader, LineDefaults defaults, AfterDoubt after_doubt,
                       const std::string& schema_directory)
    : reader_(std::move(reader)),
      after_doubt_(after_doubt),
      parser_(std::move(defaults), schema_directory) {}

LineGroup BatchInput::Take(std::size_t most) {
  LineGroup group = ahead_.valid() ? ahead_.get() : Read(most);
  number_ = group.last_line;
  ended_ = group.is_last;
  return group;
}

void BatchInput::ReadAhead(std::size_t most) {
  if (ended_ || ahead_.valid() || !reader_.Ready(kLongestLine)) return;
  ahead_ = std::async(std::launch::async, [this, most] { return Read(most); });
}

LineGroup BatchInput::Read(std::size_t most) {
  LineGroup group;
  std::size_t bytes = 0;
  while (group.commands.size() < most && bytes < kGroupBytes && reader_.Ready(kLongestLine)) {
    const auto line = reader_.Next(kLongestLine);
    group.is_last = line && !*line;
    if (group.is_last) break;
    ++read_;
    if (line) bytes += (*line)->size();
    if (!ReadLine(line, group) && after_doubt_ == AfterDoubt::kPause) break;
  }
  group.last_line = read_;
  return group;
}

void BatchInput::Await() const {
  pollfd arrived{reader_.descriptor(), POLLIN, 0};
  poll(&arrived, 1, -1);
}

bool BatchInput::Ready() { return ahead_.valid() || reader_.Ready(kLongestLine); }

// False: it is doubtful.
bool BatchInput::ReadLine(const Result<std::optional<std::string_view>>& line, LineGroup& group) {
  LineOrigin origin;
  if (line && (*line)->find_first_not_of(" \t\r") == std::string_view::npos) return true;
  auto parsed = line ? parser_.Parse(**line, origin) : Fail(line.error());
  const std::string reference = FormatReference(read_, origin);
  if (!parsed) {
    group.bad.push_back(BadLineReport(reference, origin, parsed.error()));
    return false;
  }
  for (const std::string& warning : parsed->warnings) {
    group.warnings.push_back(fmt::format("line {}: {}", read_, warning));
  }
  bool is_certain = true;
  for (LineCommand& command : parsed->commands) {
    is_certain = is_certain && command.command;
    if (command.command) command.command->reference = reference;
    command.reference = reference;
    command.line = read_;
    group.commands.push_back(std::move(command));
  }
  return is_certain;
}

}  // namespace fleetpub::app
