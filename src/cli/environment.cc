#include "cli/environment.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using std::chrono::milliseconds;

// Connects as these options say; at most the connect timeout and the deadline.
delivery::ConnectHook MakeConnectHook(mqtt::ConnectOptions options) {
  return [options = std::move(options)](mqtt::Deadline deadline) {
    mqtt::ConnectOptions timely = options;
    const auto left = std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now());
    timely.connect_timeout = std::clamp(left, milliseconds(1), options.connect_timeout);
    return mqtt::ConnectPaho(timely);
  };
}

}  // namespace

std::string FormatSite(const Context& context) {
  const auto brokers = ParseBrokers(context.options);
  return brokers ? app::FormatSite(brokers->front(), context.config.profile) : "";
}

app::Environment MakeEnvironment(const Context& context) {
  const GlobalOptions& o = context.options;
  return {.config = context.config,
          .schema_directory = o.schema_directory,
          .names_broker = !o.brokers.empty() || !o.host.empty() || o.port.has_value(),
          .site = FormatSite(context),
          .connection = [context]() -> Result<app::Connection> {
            auto options = MakeConnectOptions(context);
            if (!options) return Fail(std::move(options.error()));
            const auto timeout = options->connect_timeout;
            const auto version = options->version;
            return app::Connection{timeout, version, MakeConnectHook(*std::move(options))};
          },
          .ledger = [context](ledger::OpenMode mode) { return OpenLedger(context, mode); }};
}

}  // namespace fleetpub::cli
