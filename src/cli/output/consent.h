// Whether many robots are meant.
#pragma once

#include <string>

#include "app/observer.h"
#include "base/result.h"

namespace fleetpub::cli {

/// Asks on a terminal whether all of these are meant. Errors: ErrorKind::kUsage: refused, or nobody
/// is there to be asked.
[[nodiscard]] Status AskForConsent(const app::ConsentRequest& request);

/// Asks a question of one line or more, without its question mark. Errors: ErrorKind::kUsage: no, or
/// `refusal` when nobody is there to be asked.
[[nodiscard]] Status AskOnTerminal(const std::string& question, const std::string& refusal);

}  // namespace fleetpub::cli
