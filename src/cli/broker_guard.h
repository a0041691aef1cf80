// Which broker is meant, and whose login it gets.
#pragma once

#include <span>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "mqtt/broker_url.h"

namespace fleetpub::cli {

/// Who names a profile means its broker; only a whole --broker on the same command line says that
/// it is another. Errors: ErrorKind::kUsage.
[[nodiscard]] Status CheckSite(const Context& context, std::span<const mqtt::BrokerUrl> brokers);

/// A login of the configuration, and its leave not to verify, go to the brokers that they are
/// written for: a profile's to that
/// profile's, one outside of profiles to all that the configuration names. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Status CheckLogin(const Context& context, std::span<const mqtt::BrokerUrl> brokers);

}  // namespace fleetpub::cli
