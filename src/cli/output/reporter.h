// Prints results as they become known.
#pragma once

#include <cstddef>
#include <string>

#include "cli/output/exit_code.h"
#include "cli/output/output.h"
#include "message/report.h"

namespace fleetpub::cli {

/// Prints results and remembers the worst.
class Reporter {
 public:
  explicit Reporter(Output& output) : output_(output) {}

  /// A target of this name will be reported: names are aligned.
  void Fit(const std::string& target);

  /// With `--quiet`, a person reads only what went wrong.
  void Show(const message::Report& report);

  /// Remembers it without a word.
  void Count(const message::Report& report) { worst_ = Worse(worst_, GetExitCode(report)); }

  /// On standard error: of a dry run, whose output is payloads.
  void Explain(const message::Report& report);

  [[nodiscard]] ExitCode worst() const { return worst_; }

 private:
  Output& output_;
  std::size_t width_ = 0;
  ExitCode worst_ = ExitCode::kDone;
};

}  // namespace fleetpub::cli
