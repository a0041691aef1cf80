#include "cli/reporter.h"

namespace fleetpub::cli {

void Reporter::Show(const dispatch::Report& report) {
  worst_ = Worse(worst_, CodeOf(report));
  if (output_.json()) {
    output_.Line(ReportJson(report));
  } else if (report.error) {
    output_.Line(ReportText(report, width_, output_));
  } else {
    output_.PeopleLine(ReportText(report, width_, output_));
  }
}

}  // namespace fleetpub::cli
