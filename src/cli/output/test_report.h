// Results of tests, for those who read such files: JUnit XML, TAP 13, JSON, a page of HTML.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/time.h"

namespace fleetpub::cli {

enum class TestOutcome { kPassed, kFailed, kSkipped };

struct TestResult {
  std::string group;  ///< `H`
  std::string id;     ///< `H03`
  std::string says;   ///< what is asked for
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

/// As GitLab, GitHub and Jenkins read it.
[[nodiscard]] std::string ToJUnit(const TestReport& report);
[[nodiscard]] std::string ToTap(const TestReport& report);
[[nodiscard]] std::string ToJson(const TestReport& report);
/// One file that needs no network and can be printed.
[[nodiscard]] std::string ToHtml(const TestReport& report);

using ReportWriter = std::string (*)(const TestReport& report);
struct ReportFile {
  ReportWriter write;
  std::filesystem::path path;
};

/// `junit=FILE,html=FILE`. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::vector<ReportFile>> ParseReportFiles(
    const std::vector<std::string>& words);

/// Errors: ErrorKind::kLedger, naming the file.
[[nodiscard]] Status WriteReports(std::span<const ReportFile> files, const TestReport& report);

}  // namespace fleetpub::cli
