// What the use cases work with, as the options say.
#pragma once

#include "app/environment.h"
#include "cli/options/global_options.h"

namespace fleetpub::cli {

/// The context must outlive it.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context);

}  // namespace fleetpub::cli
