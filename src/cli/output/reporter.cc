#include "cli/output/reporter.h"

#include <unistd.h>

#include <algorithm>

#include "base/text.h"
#include "base/width.h"

namespace fleetpub::cli {

void Reporter::Fit(const std::string& target) {
  width_ = std::max(width_, base::MeasureWidth(base::Printable(target)));
}

void Reporter::Show(const message::Report& report) {
  Count(report);
  if (output_.json()) {
    output_.Line(ReportJson(report));
  } else if (report.error) {
    output_.Line(WrappedFor(STDOUT_FILENO, ReportText(report, width_, output_)));
  } else {
    output_.PeopleLine(ReportText(report, width_, output_));
  }
}

void Reporter::Explain(const message::Report& report) {
  Count(report);
  Print(stderr, WrappedFor(STDERR_FILENO, ReportText(report, width_, output_)) + "\n");
}

}  // namespace fleetpub::cli
