// What became of a command to many robots, in a few lines; and how far it has come, on a terminal.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
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
  /// kByReason: of whom nothing was told before.
  enum class Names { kByGroup, kByReason };
  /// For people: a line of counts, and one for each group (or reason) that a person has to look
  /// after, naming the first fifty of it, and for those that took much longer than the others.
  [[nodiscard]] std::vector<std::string> Lines(std::chrono::nanoseconds elapsed,
                                               std::string_view site,
                                               Names names = Names::kByGroup) const;
  /// The last object of the results (docs/manual.md).
  [[nodiscard]] std::string Json(std::chrono::nanoseconds elapsed, ExitCode code,
                                 std::string_view site) const;

 private:
  static constexpr std::size_t kGroups =
      static_cast<std::size_t>(message::StatusGroup::kErrors) + 1;
  using Slow = std::pair<std::chrono::nanoseconds, std::string>;
  // Robots of one group, and mostly of one reason.
  struct Named {
    std::size_t count = 0;
    std::vector<std::string> names;  // the first fifty
    void Add(const std::string& name);
  };
  static std::string Format(std::string_view title, const Named& named);
  /// Which of the finished took more than a second and three times the median; the slowest first.
  [[nodiscard]] std::vector<Slow> TheSlow() const;

  std::array<std::size_t, kGroups> counts_{};
  std::array<Named, kGroups> names_;
  std::map<std::pair<message::CommandStatus, std::string>, Named> reasons_;
  std::vector<float> elapsed_;  ///< seconds, of all
  std::vector<Slow> slowest_;   ///< of the finished, the slowest first
};

/// `[====    ] 6 of 9  5 finished, 1 failed`
[[nodiscard]] std::string FormatProgress(const FleetSummary& summary, std::size_t total);

}  // namespace fleetpub::cli
