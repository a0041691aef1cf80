#include "cli/environment.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {

using std::chrono::milliseconds;

app::Environment MakeEnvironment(const Context& context) {
  return {.config = context.config,
          .schema_directory = context.options.schema_directory,
          .connection = [context]() -> Result<app::Connection> {
            auto options = MakeConnectOptions(context);
            if (!options) return Fail(std::move(options.error()));
            const auto timeout = options->connect_timeout;
            const auto version = options->version;
            return app::Connection{timeout, version, MakeConnectHook(*std::move(options))};
          },
          .ledger = [context](ledger::OpenMode mode) { return OpenLedger(context, mode); }};
}

delivery::ConnectHook MakeConnectHook(mqtt::ConnectOptions options) {
  return [options = std::move(options)](mqtt::Deadline deadline) {
    mqtt::ConnectOptions timely = options;
    const auto left = std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now());
    timely.connect_timeout = std::clamp(left, milliseconds(1), options.connect_timeout);
    return mqtt::ConnectPaho(timely);
  };
}

}  // namespace fleetpub::cli
