// `--report`: files that tell of tests, for CI and for people.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/output/test_report.h"

namespace fleetpub::cli {

class OptionSet;

void DeclareReport(OptionSet& set, std::vector<std::string>& words);
/// `--record`, of what is heard while it is tested.
void DeclareRecord(OptionSet& set, std::string& file);

using ReportWriter = std::string (*)(const TestReport& report);
struct ReportFile {
  ReportWriter write;
  std::filesystem::path path;
};

/// `junit=FILE,html=FILE`. Each can be written now, and stays as it is. Errors: ErrorKind::kUsage;
/// kLedger, naming the file.
[[nodiscard]] Result<std::vector<ReportFile>> ParseReportFiles(
    const std::vector<std::string>& words);

/// The report ends now. Errors: ErrorKind::kLedger, naming the file.
[[nodiscard]] Status WriteReports(std::span<const ReportFile> files, TestReport report);

}  // namespace fleetpub::cli
