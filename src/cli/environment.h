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

/// What the retained flag of a received message says: that the broker had stored it, or on MQTT 5
/// what its publisher said.
enum class Retained { kStored, kAsPublished };

/// The context must outlive it. The first connection is made with this patience.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context,
                                               std::chrono::milliseconds patience = {},
                                               Retained retained = Retained::kStored);

/// The same, connecting as these options say.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context,
                                               mqtt::ConnectOptions options);

/// The same with a recording in the broker's place, unless `from` is empty.
[[nodiscard]] app::Environment MakeEnvironment(const Context& context, const std::string& from,
                                               delivery::Play play,
                                               std::chrono::milliseconds patience = {});

/// What is read from a recording is old: when it ended, and what is wrong with the file.
void TellRecording(const app::Environment& environment, Output& output);

/// The broker that the options name, and the profile: `mqtts://north (profile north)`. Empty when they
/// name none that can be read.
[[nodiscard]] std::string FormatSite(const Context& context);

}  // namespace fleetpub::cli
