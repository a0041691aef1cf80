#include "cli/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/text.h"
#include "base/time.h"
#include "delivery/first_connection.h"
#include "mqtt/paho/paho_transport.h"

namespace fleetpub::cli {
namespace {

using std::chrono::milliseconds;

// One attempt; at most the connect timeout and the deadline.
auto ConnectBy(const mqtt::ConnectOptions& options, mqtt::Deadline deadline,
               bool* may_heal = nullptr) {
  mqtt::ConnectOptions timely = options;
  const auto left = std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now());
  timely.connect_timeout = std::clamp(left, milliseconds(1), options.connect_timeout);
  return mqtt::ConnectPaho(timely, may_heal);
}

// Connects as these options say.
app::Connection MakeConnection(mqtt::ConnectOptions options, milliseconds patience,
                               Output& output) {
  const auto timeout = options.connect_timeout;
  const auto version = options.version;
  return {timeout, version,
          [options = std::move(options), patience, &output](mqtt::Deadline deadline) mutable {
            const auto first = std::exchange(patience, milliseconds(0));
            return first.count() > 0 ? ConnectPatiently(options, first, output)
                                     : ConnectBy(options, deadline);
          }};
}

}  // namespace

std::string FormatSite(const Context& context) {
  const auto brokers = ParseBrokers(context.options);
  return brokers ? app::FormatSite(brokers->front(), context.config.profile) : "";
}

Result<std::unique_ptr<mqtt::Transport>> ConnectPatiently(const mqtt::ConnectOptions& options,
                                                          milliseconds patience, Output& output) {
  if (patience.count() == 0) return mqtt::ConnectPaho(options);
  const auto waits = [&](const Error& error) {
    output.Info(
        fmt::format("{}; trying again for {}", error.message, base::FormatElapsed(patience)));
  };
  return delivery::Connect(
      {.open = [&](mqtt::Deadline deadline,
                   bool& may_heal) { return ConnectBy(options, deadline, &may_heal); },
       .waits = waits},
      std::chrono::steady_clock::now() + patience);
}

app::Environment MakeEnvironment(const Context& context, milliseconds patience, Retained retained) {
  const GlobalOptions& o = context.options;
  return {.config = context.config,
          .schema_directory = o.schema_directory,
          .names_broker = !o.brokers.empty() || !o.host.empty() || o.port.has_value(),
          .site = FormatSite(context),
          .connection = [context, patience, retained]() -> Result<app::Connection> {
            auto options = MakeConnectOptions(context);
            if (!options) return Fail(std::move(options.error()));
            options->retain_as_published = retained == Retained::kAsPublished;
            return MakeConnection(*std::move(options), patience, context.output);
          },
          .ledger = [context](ledger::OpenMode mode) { return OpenLedger(context, mode); }};
}

app::Environment MakeEnvironment(const Context& context, mqtt::ConnectOptions options) {
  app::Environment environment = MakeEnvironment(context);
  environment.connection = [options = std::move(options),
                            &output = context.output]() -> Result<app::Connection> {
    return MakeConnection(options, {}, output);
  };
  return environment;
}

app::Environment MakeEnvironment(const Context& context, const std::string& from,
                                 delivery::Play play, milliseconds patience) {
  app::Environment environment = MakeEnvironment(context, patience);
  if (from.empty()) return environment;
  const auto recording = std::make_shared<delivery::PlayedRecording>(from, play);
  environment.recording = recording;
  environment.site = base::Printable(from);
  environment.connection = [recording]() -> Result<app::Connection> {
    return app::Connection{
        .open = [recording](mqtt::Deadline /*deadline*/) { return recording->Open(); }};
  };
  return environment;
}

void TellRecording(const app::Environment& environment, Output& output) {
  if (!environment.recording) return;
  const delivery::PlayedRecording& recording = *environment.recording;
  const std::string complaint = recording.Complaint();
  if (!complaint.empty()) output.Warn(complaint);
  if (output.json()) return;
  output.PeopleLine(fmt::format("from {}, as of {}", base::Printable(recording.name()),
                                base::FormatLocal(recording.now())));
}

}  // namespace fleetpub::cli
