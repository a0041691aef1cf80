// What `fleetpub batch` reads and prints: lines made into commands as far as they are there, and a
// result for each.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/line_reader.h"
#include "base/result.h"
#include "cli/batch_line.h"
#include "cli/exit_code.h"
#include "cli/global_options.h"
#include "dispatch/report.h"

namespace fleetpub::cli {

/// Prints results and remembers the worst.
class BatchResults {
 public:
  explicit BatchResults(Output& output) : output_(output) {}

  /// The report's reference is what ReferenceOf() made.
  void Show(const dispatch::Report& report);
  /// Of a command that could not be made.
  void ShowBad(std::string reference, const LineOrigin& origin, const Error& error);

  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  Output& output_;
  ExitCode worst_ = ExitCode::kDone;
};

enum class AfterBadLine { kGoOn, kPause };

class BatchInput {
 public:
  /// `context` and `results` must outlive it. After a bad line Take() returns at once with kPause.
  BatchInput(base::LineReader reader, LineDefaults defaults, AfterBadLine after_bad_line,
             const Context& context, BatchResults& results);

  /// About so many commands at most, and none that would have to be waited for. Bad lines are
  /// reported.
  [[nodiscard]] std::vector<dispatch::Command> Take(std::size_t most);

  /// Until there is something to read, be it the end.
  void Await() const;

  [[nodiscard]] bool ended() const { return ended_; }
  /// Whether there is something for Take(): a line, or the end.
  [[nodiscard]] bool Ready();
  [[nodiscard]] int descriptor() const { return reader_.descriptor(); }
  /// Of the last line that was taken, counted from 1.
  [[nodiscard]] std::size_t number() const { return number_; }

 private:
  bool TakeLine(const Result<std::optional<std::string_view>>& line,
                std::vector<dispatch::Command>& commands);
  [[nodiscard]] std::string ReferenceOf(const LineOrigin& origin) const;

  base::LineReader reader_;
  AfterBadLine after_bad_line_;
  Output& output_;
  BatchResults& results_;
  LineParser parser_;
  std::size_t number_ = 0;
  bool ended_ = false;
};

}  // namespace fleetpub::cli
