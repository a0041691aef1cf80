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

}  // namespace fleetpub::dispatch
