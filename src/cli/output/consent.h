// Whether many robots are meant.
#pragma once

#include "app/observer.h"
#include "base/result.h"

namespace fleetpub::cli {

/// Asks on a terminal whether all of these are meant. Errors: ErrorKind::kUsage: refused, or nobody
/// is there to be asked.
[[nodiscard]] Status AskForConsent(const app::ConsentRequest& request);

}  // namespace fleetpub::cli
