// What became of a command to many robots, in a few lines; and how far it has come, on a terminal.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cli/output/exit_code.h"
#include "cli/output/output.h"
#include "message/report.h"

namespace fleetpub::cli {

/// Counts results and remembers whom to name. Small, however many there are.
class FleetSummary {
 public:
  void Add(const message::Report& report);

  [[nodiscard]] std::size_t robots() const { return elapsed_.size(); }
  [[nodiscard]] std::size_t count(message::StatusGroup group) const {
    return counts_[static_cast<std::size_t>(group)];
  }

  /// `965 finished, 10 failed`: those groups that have any.
  [[nodiscard]] std::string Counts() const;
  /// For people: a line of counts, and one for each group that a person has to look after, naming
  /// the first fifty of it, and for those that took much longer than the others.
  [[nodiscard]] std::vector<std::string> Lines(std::chrono::nanoseconds elapsed,
                                               std::string_view site) const;
  /// The last object of the results (docs/manual.md).
  [[nodiscard]] std::string Json(std::chrono::nanoseconds elapsed, ExitCode code,
                                 std::string_view site) const;

 private:
  static constexpr std::size_t kGroups =
      static_cast<std::size_t>(message::StatusGroup::kErrors) + 1;
  using Slow = std::pair<std::chrono::nanoseconds, std::string>;
  /// Which of the finished took more than a second and three times the median; the slowest first.
  [[nodiscard]] std::vector<Slow> TheSlow() const;

  std::array<std::size_t, kGroups> counts_{};
  std::array<std::vector<std::string>, kGroups> names_;
  std::vector<float> elapsed_;  ///< seconds, of all
  std::vector<Slow> slowest_;   ///< of the finished, the slowest first
};

/// A line on standard error that is redrawn in place, when that is a terminal and it takes long.
class ProgressBar {
 public:
  ProgressBar(std::size_t total, Output& output);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar() { output_.ClearPassing(); }

  [[nodiscard]] bool IsPossible() const { return possible_; }
  /// At most ten times a second.
  void Draw(const FleetSummary& summary);

 private:
  Output& output_;
  std::size_t total_;
  bool possible_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace fleetpub::cli
