// Results of tests, for those who read such files: JUnit XML, TAP 13, JSON, a page of HTML.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/verdict.h"
#include "base/time.h"
#include "cli/output/output.h"

namespace fleetpub::cli {

enum class TestOutcome { kPassed, kFailed, kSkipped };

struct TestResult {
  std::string group;  ///< `H`
  std::string id;     ///< `H03`
  std::string says;   ///< what is asked for; "": the id tells
  TestOutcome outcome = TestOutcome::kPassed;
  std::string verdict;               ///< the word for it: `INCONCLUSIVE`
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

[[nodiscard]] TestOutcome ToOutcome(app::Verdict verdict);
[[nodiscard]] Tone ToTone(app::Verdict verdict);

struct VerdictCounts {
  std::size_t passed = 0;
  std::size_t failed = 0;
  std::size_t skipped = 0;
  std::size_t inconclusive = 0;

  void Add(app::Verdict verdict);
  /// `3 passed, 1 failed, …`
  [[nodiscard]] std::string ToText() const;
  /// Members of an object.
  [[nodiscard]] std::string ToJson() const;
};

/// As GitLab, GitHub and Jenkins read it.
[[nodiscard]] std::string ToJUnit(const TestReport& report);
[[nodiscard]] std::string ToTap(const TestReport& report);
[[nodiscard]] std::string ToJson(const TestReport& report);
/// One file that needs no network and can be printed.
[[nodiscard]] std::string ToHtml(const TestReport& report);

}  // namespace fleetpub::cli
