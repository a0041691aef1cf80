// What the use cases work with, as the options say.
#pragma once

#include <chrono>

#include "app/environment.h"
#include "cli/options/global_options.h"

namespace fleetpub::cli {

/// Connects, and while the broker is not there tries again for so long, which is told. Errors:
/// those of mqtt::ConnectPaho.
[[nodiscard]] Result<std::unique_ptr<mqtt::Transport>> ConnectPatiently(
    const mqtt::ConnectOptions& options, std::chrono::milliseconds patience, Output& output);

/// The context must outlive it. The first connection is made with this patience.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context,
                                               std::chrono::milliseconds patience = {});

/// The broker that the options name, and the profile: `mqtts://north (profile north)`. Empty when they
/// name none that can be read.
[[nodiscard]] std::string FormatSite(const Context& context);

}  // namespace fleetpub::cli
