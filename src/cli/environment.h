// What the use cases work with, as the options say.
#pragma once

#include "app/environment.h"
#include "cli/options/global_options.h"
#include "delivery/connect_hook.h"

namespace fleetpub::cli {

/// The context must outlive it.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context);

/// The broker that the options name, and the profile: `mqtts://north (profile north)`. Empty when they
/// name none that can be read.
[[nodiscard]] std::string FormatSite(const Context& context);

/// Connects as these options say; at most the connect timeout and the deadline.
[[nodiscard]] delivery::ConnectHook MakeConnectHook(mqtt::ConnectOptions options);

}  // namespace fleetpub::cli
