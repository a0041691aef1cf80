#include "dispatch/verdict.h"

#include <array>

namespace fleetpub::dispatch {
namespace {

// In the order of the enumeration.
constexpr std::array<std::string_view, 14> kNames = {
    "DRY_RUN",   "SENT",     "PUBLISHED", "ACCEPTED", "FINISHED", "FAILED",  "REJECTED",
    "RETRIABLE", "VANISHED", "OFFLINE",   "TIMEOUT",  "REFUSED",  "INVALID", "ERROR",
};
static_assert(kNames.size() == static_cast<std::size_t>(Verdict::kError) + 1);

}  // namespace

std::string_view NameOf(Verdict verdict) { return kNames[static_cast<std::size_t>(verdict)]; }

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
