#include "cli/options/report_options.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "base/time.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kReport = "Report";

constexpr auto kWriters = std::to_array<std::pair<std::string_view, ReportWriter>>(
    {{"junit", ToJUnit}, {"tap", ToTap}, {"json", ToJson}, {"html", ToHtml}});

tl::unexpected<Error> CannotBeWritten(const std::filesystem::path& path) {
  return Fail(ErrorKind::kLedger,
              fmt::format("{} cannot be written: {}", base::Printable(path.string()),
                          std::system_category().message(errno)));
}

// Neither need be there.
bool IsSame(const std::filesystem::path& a, const std::filesystem::path& b) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  return fs::weakly_canonical(fs::absolute(a, unknown), unknown) ==
         fs::weakly_canonical(fs::absolute(b, unknown), unknown);
}

Status CheckWritable(const std::filesystem::path& path) {
  const int created = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (created >= 0) {
    close(created);
    unlink(path.c_str());
    return {};
  }
  if (errno != EEXIST) return CannotBeWritten(path);
  std::error_code unknown;
  const bool is_folder = std::filesystem::is_directory(path, unknown);
  if (!is_folder && access(path.c_str(), W_OK) == 0) return {};
  if (is_folder) errno = EISDIR;
  return CannotBeWritten(path);
}

}  // namespace

void DeclareReport(OptionSet& set, std::vector<std::string>& words) {
  set.AddOption("--report", words,
                "Write files: junit=FILE, tap=FILE, json=FILE, html=FILE; repeatable")
      .Type("KIND=FILE")
      .OneValueEach()
      .Group(kReport);
}

void DeclareRecord(OptionSet& set, std::string& file) {
  set.AddOption("--record", NewFile(file), "Record all that is heard, as record does")
      .Type("FILE")
      .Group(kReport);
}

Result<std::vector<ReportFile>> ParseReportFiles(const std::vector<std::string>& words) {
  std::vector<ReportFile> files;
  for (const std::string& word : words) {
    for (const std::string& part : base::Split(word, ',')) {
      const auto equals = part.find('=');
      const auto* const writer =
          std::find_if(kWriters.begin(), kWriters.end(),
                       [&](const auto& one) { return one.first == part.substr(0, equals); });
      if (equals == std::string::npos || equals + 1 == part.size() || writer == kWriters.end()) {
        return Fail(ErrorKind::kUsage,
                    fmt::format("--report: '{}' is no report: --report junit=out.xml, or tap=, "
                                "json=, html=",
                                base::Printable(part)));
      }
      const std::filesystem::path path = part.substr(equals + 1);
      const bool is_taken = std::any_of(files.begin(), files.end(), [&](const ReportFile& file) {
        return IsSame(file.path, path);
      });
      if (path == "-" || is_taken) {
        return Fail(ErrorKind::kUsage,
                    fmt::format("--report: {} {}: give each report a file of its own",
                                base::Printable(part),
                                is_taken ? "would overwrite another" : "names no file"));
      }
      files.push_back({writer->second, path});
      if (auto ok = CheckWritable(files.back().path); !ok) return Fail(std::move(ok.error()));
    }
  }
  return files;
}

Status WriteReports(std::span<const ReportFile> files, TestReport report) {
  report.elapsed = std::chrono::duration_cast<std::chrono::milliseconds>(
      base::WallTime::clock::now() - report.started);
  report.properties.emplace_back("tool", "fleetpub " FLEETPUB_VERSION);
  for (const ReportFile& file : files) {
    std::ofstream out(file.path, std::ios::binary | std::ios::trunc);
    out << file.write(report);
    out.close();
    if (!out.good()) return CannotBeWritten(file.path);
  }
  return {};
}

}  // namespace fleetpub::cli
