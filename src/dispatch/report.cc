#include "dispatch/report.h"

namespace fleetpub::dispatch {

std::string_view NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kDryRun:
      return "DRY_RUN";
    case Verdict::kSent:
      return "SENT";
    case Verdict::kPublished:
      return "PUBLISHED";
    case Verdict::kInvalid:
      return "INVALID";
    case Verdict::kError:
      return "ERROR";
  }
  return "ERROR";
}

}  // namespace fleetpub::dispatch
