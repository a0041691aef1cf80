// Results of tests, for those who read such files: JUnit XML, TAP 13, JSON, a page of HTML.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/verdict.h"
#include "base/time.h"
#include "cli/output/exit_code.h"
#include "cli/output/output.h"

namespace fleetpub::cli {

struct TestResult {
  std::string group;  ///< `H`
  std::string id;     ///< `H03`
  std::string says;   ///< what is asked for; "": the id tells
  app::Verdict verdict = app::Verdict::kPass;
  std::string why;                   ///< one line
  std::vector<std::string> details;  ///< one line each
};

struct TestReport {
  std::string name;  ///< `fleetpub conform KIT/0001`
  std::vector<std::pair<std::string, std::string>> properties;
  base::WallTime started;
  std::chrono::milliseconds elapsed{0};
  std::vector<TestResult> results;
};

/// The verdict in its colour, as the first column of a line.
[[nodiscard]] std::string VerdictColumn(app::Verdict verdict, const Output& output);
/// `; see state headerId 3`; "" without any.
[[nodiscard]] std::string SeeEvidence(const std::vector<std::string>& evidence);

struct VerdictCounts {
  std::size_t passed = 0;
  std::size_t failed = 0;
  std::size_t skipped = 0;
  std::size_t inconclusive = 0;

  void Add(app::Verdict verdict);
  /// What reports call skipped: neither passed nor failed.
  [[nodiscard]] std::size_t undecided() const { return skipped + inconclusive; }
  /// `3 passed, 1 failed, …`
  [[nodiscard]] std::string ToText() const;
  /// Members of an object.
  [[nodiscard]] std::string ToJson() const;
  /// Of the process: a signal that stopped it comes first. `is_open`: something is not decided.
  [[nodiscard]] ExitCode ToExitCode(bool is_open) const;
};

/// As GitLab, GitHub and Jenkins read it.
[[nodiscard]] std::string ToJUnit(const TestReport& report);
[[nodiscard]] std::string ToTap(const TestReport& report);
[[nodiscard]] std::string ToJson(const TestReport& report);
/// One file that needs no network and can be printed.
[[nodiscard]] std::string ToHtml(const TestReport& report);

}  // namespace fleetpub::cli
