#include "dispatch/verdict.h"

namespace fleetpub::dispatch {

std::optional<ErrorKind> TroubleOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kFailed:
    case Verdict::kRejected:
      return ErrorKind::kRejected;
    case Verdict::kRetriable:
    case Verdict::kVanished:
    case Verdict::kOffline:
    case Verdict::kTimeout:
      return ErrorKind::kUnconfirmed;
    default:
      return std::nullopt;
  }
}

}  // namespace fleetpub::dispatch
