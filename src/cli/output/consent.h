// Whether many robots are meant.
#pragma once

#include <functional>
#include <string>

#include "app/observer.h"
#include "base/result.h"

namespace fleetpub::cli {

/// Asks on a terminal whether all of these are meant. Errors: ErrorKind::kUsage: refused, or nobody
/// is there to be asked.
[[nodiscard]] Status AskForConsent(const app::ConsentRequest& request);

/// Asks a question of one line or more, without its question mark. `await` returns once the
/// answer can be read from the descriptor that it is given. Errors: ErrorKind::kUsage: no, or
/// `refusal` when nobody is there to be asked.
[[nodiscard]] Status AskOnTerminal(const std::string& question, const std::string& refusal,
                                   const std::function<void(int descriptor)>& await = {});

}  // namespace fleetpub::cli
