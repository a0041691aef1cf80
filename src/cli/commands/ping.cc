// `fleetpub ping`: can the broker be reached with these settings, what is it, and what does it
// grant?
#include <fmt/format.h>

#include <chrono>
#include <memory>

#include "app/dialect_resolver.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;

// What fleet control listens to.
constexpr std::array<std::string_view, 3> kTopics = {"connection", "state", "factsheet"};

struct Grant {
  std::string topic;
  bool granted = false;
  std::string reason;
};

struct Finding {
  std::string url;
  std::string software;  ///< "" when the broker does not say
  std::string mqtt;
  std::vector<Grant> grants;
  std::vector<std::string> limits;
  std::chrono::nanoseconds connect{0};
  std::chrono::nanoseconds round_trip{0};
};

Result<std::chrono::nanoseconds> TimedSubscribe(mqtt::Transport& transport,
                                                const std::string& filter,
                                                steady_clock::time_point deadline) {
  const auto start = steady_clock::now();
  if (auto ok = transport.Subscribe({&filter, 1}, mqtt::kListeningQos, deadline); !ok) {
    return Fail(ok.error());
  }
  return steady_clock::now() - start;
}

// mosquitto and others publish their name retained; a broker that refuses the topic or stays silent
// is no trouble. To be asked first: what robots have left comes with the other topics.
void AskForSoftware(mqtt::Transport& transport, steady_clock::time_point deadline,
                    Finding& finding) {
  const auto took = TimedSubscribe(transport, "$SYS/broker/version", deadline);
  if (!took) return;
  finding.round_trip = *took;
  const auto patience = steady_clock::now() + std::chrono::milliseconds(200);
  const auto message = transport.Receive(std::min(deadline, patience));
  if (message && *message) finding.software = base::Printable((*message)->payload);
}

std::vector<std::string> ListLimits(const mqtt::ServerInfo& server) {
  std::vector<std::string> limits;
  if (server.maximum_qos && *server.maximum_qos != mqtt::Qos::kExactlyOnce) {
    limits.push_back(fmt::format("QoS above {}", static_cast<int>(*server.maximum_qos)));
  }
  if (server.KeepsNothing()) limits.emplace_back("retained messages");
  if (server.wildcard_available == false) limits.emplace_back("wildcard subscriptions");
  if (server.maximum_packet_size) {
    limits.push_back(fmt::format("packets above {} bytes", *server.maximum_packet_size));
  }
  return limits;
}

// What to subscribe to for each of kTopics. Errors: ErrorKind::kUsage.
Result<std::vector<std::string>> MakeFilters(const app::VdaOptions& vda,
                                             const config::Config& config) {
  const auto dialect = app::ParseDialect(app::WithConfig(vda, config));
  if (!dialect) return Fail(dialect.error());
  return vda5050::DiscoveryFilters(dialect->topics, {}, kTopics);
}

Result<Finding> Explore(const mqtt::ConnectOptions& connect, std::chrono::milliseconds patience,
                        const std::vector<std::string>& filters, Output& output) {
  const auto start = steady_clock::now();
  const auto transport = ConnectPatiently(connect, patience, output);
  if (!transport) return Fail(transport.error());
  const auto deadline = steady_clock::now() + connect.connect_timeout;
  const mqtt::ServerInfo& server = (*transport)->server();
  Finding finding{.url = server.broker.ToString(),
                  .mqtt = server.version == mqtt::ProtocolVersion::k5 ? "5" : "3.1.1",
                  .limits = ListLimits(server),
                  .connect = steady_clock::now() - start};
  AskForSoftware(**transport, deadline, finding);
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    const auto took = TimedSubscribe(**transport, filters[i], deadline);
    finding.grants.push_back(
        {std::string(kTopics[i]), took.has_value(), took ? "" : took.error().message});
    if (took && finding.round_trip.count() == 0) finding.round_trip = *took;
  }
  (*transport)->Disconnect();
  return finding;
}

void ShowJson(const Finding& finding, Output& output) {
  std::string grants;
  for (const Grant& grant : finding.grants) {
    grants += fmt::format(R"({}"{}":{})", grants.empty() ? "" : ",", grant.topic, grant.granted);
  }
  std::string limits;
  for (const std::string& limit : finding.limits) {
    limits += (limits.empty() ? "" : ",") + base::JsonString(limit);
  }
  output.Line(
      fmt::format(R"({{"broker":{},"reachable":true,"mqtt":"{}","software":{},"connectMs":{:.3f},)"
                  R"("roundTripMs":{:.3f},"subscribe":{{{}}},"refuses":[{}]}})",
                  base::JsonString(finding.url), finding.mqtt, base::JsonString(finding.software),
                  static_cast<double>(finding.connect.count()) / 1e6,
                  static_cast<double>(finding.round_trip.count()) / 1e6, grants, limits));
}

void ShowText(const Finding& finding, Output& output) {
  output.PeopleLine(fmt::format("{}  reachable  MQTT {}  connected in {}, round trip {}",
                                finding.url, finding.mqtt, base::FormatElapsed(finding.connect),
                                base::FormatElapsed(finding.round_trip)));
  if (!finding.software.empty()) {
    output.PeopleLine(fmt::format("  software   {}", finding.software));
  }
  for (const Grant& grant : finding.grants) {
    output.PeopleLine(fmt::format("  subscribe  {:<11} {}", grant.topic,
                                  grant.granted ? "granted" : "refused: " + grant.reason));
  }
  for (const std::string& limit : finding.limits) {
    output.PeopleLine(fmt::format("  refuses    {}", limit));
  }
  output.PeopleLine("  publish    not tried: it would reach robots");
}

struct PingOptions {
  app::VdaOptions vda;
  std::chrono::milliseconds patience{0};
};

Result<ExitCode> RunPing(const PingOptions& options, const Context& context) {
  const auto filters = MakeFilters(options.vda, context.config);
  if (!filters) return Fail(filters.error());
  const auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(connect.error());
  const auto finding = Explore(*connect, options.patience, *filters, context.output);
  if (!finding) {
    if (context.output.json()) {
      context.output.Line(fmt::format(R"({{"reachable":false,"message":{}}})",
                                      base::JsonString(finding.error().message)));
    }
    return Fail(finding.error());
  }
  if (context.output.json()) {
    ShowJson(*finding, context.output);
  } else {
    ShowText(*finding, context.output);
  }
  const bool all = std::all_of(finding->grants.begin(), finding->grants.end(),
                               [](const Grant& grant) { return grant.granted; });
  return all ? ExitCode::kDone : ExitCode::kBroker;
}

}  // namespace

Run DeclarePing(OptionSet& set) {
  const auto options = std::make_shared<PingOptions>();
  set.AddOption("-w,--wait", Duration(options->patience),
                "Keep trying for so long until the broker is there [0s]")
      .Group("Waiting");
  DeclareTopicOptions(set, options->vda);
  return [options](const Context& context) { return RunPing(*options, context); };
}

}  // namespace fleetpub::cli
