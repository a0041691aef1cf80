// What `fleetpub batch` reads: lines made into commands as far as they are there.
#pragma once

#include <cstddef>
#include <future>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/batch_line.h"
#include "base/line_reader.h"
#include "base/result.h"
#include "message/report.h"

namespace fleetpub::app {

/// What follows a line that is bad, or may yet be refused as its robot has to be looked up.
enum class AfterDoubt { kGoOn, kPause };

/// Lines that were there together.
struct LineGroup {
  std::vector<LineCommand> commands;
  std::vector<message::Report> bad;  ///< of lines that made no command
  std::vector<std::string> warnings;
  std::size_t last_line = 0;  ///< counted from 1
  bool is_last = false;       ///< the input has ended
};

/// Reads lines and makes commands of them; when told to, on a thread beside the caller's.
class BatchInput {
 public:
  /// With kPause Take() returns at once after a doubtful line.
  BatchInput(base::LineReader reader, LineDefaults defaults, AfterDoubt after_doubt,
             const std::string& schema_directory);

  /// About so many commands at most, and none that would have to be waited for. What was read ahead
  /// comes first.
  [[nodiscard]] LineGroup Take(std::size_t most);

  /// Begins with the next Take() while the caller does something else, if it need not wait for
  /// lines. Until then nothing else of this object may be called but Take, ended and number.
  void ReadAhead(std::size_t most);

  /// Until there is something to read, be it the end.
  void Await() const;

  /// What Take() has returned so far: the end; the number of its last line.
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Whether there is something for Take(): a line, or the end.
  [[nodiscard]] bool Ready();
  [[nodiscard]] int descriptor() const { return reader_.descriptor(); }

 private:
  [[nodiscard]] LineGroup Read(std::size_t most);
  bool ReadLine(const Result<std::optional<std::string_view>>& line, LineGroup& group);

  base::LineReader reader_;
  AfterDoubt after_doubt_;
  LineParser parser_;
  std::size_t read_ = 0;  // lines
  std::size_t number_ = 0;
  bool ended_ = false;
  std::future<LineGroup> ahead_;  // the last member: what it works with outlives it
};

/// The report on a line of which no command was made.
[[nodiscard]] message::Report BadLineReport(std::string reference, const LineOrigin& origin,
                                            const Error& error);

}  // namespace fleetpub::app
