#include "app/conform.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/deliver.h"
#include "app/order_path.h"
#include "app/robot_listener.h"
#include "base/text.h"
#include "delivery/recorded.h"
#include "schema/schema.h"

namespace fleetpub::app {
namespace {

using conformance::Level;
using std::chrono::steady_clock;

// The broker, and a recording of what it says.
class BrokerWire final : public conformance::Wire {
 public:
  BrokerWire(const ConformRequest& request, RobotListener& listener, Observer& observer)
      : request_(request), listener_(listener), observer_(observer) {}

  Status OpenRecording() {
    return recorder_.Begin(request_.recording, request_.tool, listener_.server(),
                           listener_.filters(), mqtt::Qos::kAtLeastOnce);
  }
  Status EndRecording() { return recorder_.End(); }

  Status Send(const message::Command& command) override {
    return listener_.Send(command, mqtt::Qos::kAtMostOnce);
  }

  std::optional<std::pair<std::string, mqtt::Message>> Next(conformance::TimePoint until) override {
    constexpr std::chrono::milliseconds kGlance{100};  // at whether somebody stops it
    const auto glance = std::min(until, steady_clock::now() + kGlance);
    while (auto message = listener_.subscription().Next(glance)) {
      recorder_.Add(*message);
      const auto levels = vda5050::ReadTopic(listener_.dialect().topics, message->topic,
                                             listener_.address().manufacturer);
      if (!levels || levels->robot != listener_.address()) continue;
      const auto& names = vda5050::kReportTopics;
      if (std::find(names.begin(), names.end(), levels->topic_name) == names.end()) continue;
      return std::pair(levels->topic_name, *std::move(message));
    }
    return std::nullopt;
  }

  [[nodiscard]] conformance::TimePoint Now() const override { return steady_clock::now(); }
  [[nodiscard]] base::WallTime WallNow() const override { return base::WallTime::clock::now(); }
  [[nodiscard]] bool IsStopped() const override { return observer_.IsStopped(); }

 private:
  const ConformRequest& request_;
  RobotListener& listener_;
  Observer& observer_;
  delivery::Recorder recorder_;
};

// There and back along nodes that somebody named.
Result<conformance::Way> PlanWay(const ConformRequest& request, const RobotListener& listener,
                                 Log& log) {
  conformance::Way way{.distance = request.distance};
  if (request.nodes.empty()) return way;
  if (request.nodes.size() < 3) {
    return Fail(ErrorKind::kUsage, "a way needs three nodes: --nodes n1,n2,n3");
  }
  const auto plan = [&](std::vector<std::string> nodes) -> Result<vda5050::OrderPath> {
    PathRequest path{.nodes = std::move(nodes),
                     .points = {},
                     .stops = {},
                     .from = {},
                     .actions = {},
                     .blocking_type = {},
                     .vehicle_type = request.vehicle_type};
    const std::string start = path.nodes.front();
    auto planned = PlanPath(path, request.site.get(),
                            {.address = listener.address(),
                             .factsheet = listener.robot().second.factsheet.get(),
                             .state = nullptr,
                             .start = start});
    if (!planned) return Fail(std::move(planned.error()));
    for (const std::string& warning : planned->warnings) log.Warn(warning);
    return std::move(planned->path);
  };
  auto there = plan(request.nodes);
  if (!there) return Fail(std::move(there.error()));
  way.there = *std::move(there);
  if (request.nodes.front() == request.nodes.back()) return way;
  auto back = plan({request.nodes.rbegin(), request.nodes.rend()});
  if (!back) return Fail(std::move(back.error()));
  way.back = *std::move(back);
  return way;
}

std::string DescribeWay(const ConformRequest& request) {
  const std::string load =
      request.selection.Has("A07") ? "; picks and drops a load, if it can, where it stands" : "";
  if (request.nodes.empty()) {
    return fmt::format("{:.1f} m straight on from where it stands, and back{}", request.distance,
                       load);
  }
  return fmt::format("along {}, and back{}", base::Printable(base::Join(request.nodes, ", ")),
                     load);
}

Result<ConformReport> Test(const ConformRequest& request, RobotListener& listener,
                           const Environment& environment, const DriveConsent& consent,
                           const conformance::Progress& progress, Observer& observer) {
  auto cases = conformance::ListCases();
  const auto version = listener.dialect().version;
  std::erase_if(cases, [&](const conformance::Case& one) { return !one.AppliesTo(version); });
  if (!request.selection.RunsAny(cases)) {
    return Fail(ErrorKind::kUsage, fmt::format("none of these cases is of VDA 5050 {}",
                                               vda5050::GetFacts(version).name));
  }
  auto way = PlanWay(request, listener, observer);
  if (!way) return Fail(std::move(way.error()));
  if (request.selection.level == Level::kDrive) {
    if (auto agreed = consent(listener.address(), DescribeWay(request)); !agreed) {
      return Fail(std::move(agreed.error()));
    }
  }
  BrokerWire wire(request, listener, observer);
  if (auto opened = wire.OpenRecording(); !opened) return Fail(std::move(opened.error()));
  const auto& factsheet = listener.robot().second.factsheet;
  schema::Registry registry(environment.schema_directory);
  conformance::Run run(
      {.address = listener.address(),
       .dialect = listener.dialect(),
       .factsheet = factsheet == nullptr ? std::nullopt : std::optional(*factsheet),
       .way = *std::move(way)},
      wire, registry);
  ConformReport report{.target = listener.address().ToString(),
                       .version = std::string(vda5050::GetFacts(listener.dialect().version).name)};
  observer.Wait(fmt::format("testing {}", listener.name()), listener.end(), "Ctrl-C ends it");
  report.outcome = conformance::Conduct(run, request.selection, progress);
  observer.Wait("");
  report.abort_reason = run.abort_reason();
  if (auto ended = wire.EndRecording(); !ended) return Fail(std::move(ended.error()));
  listener.subscription().Disconnect();
  return report;
}

}  // namespace

Result<ConformReport> Conform(const ConformRequest& request, const Environment& environment,
                              const DriveConsent& consent, const conformance::Progress& progress,
                              Observer& observer) {
  RobotTopics topics{.names = {"state"}, .qos = mqtt::Qos::kAtLeastOnce};
  for (const std::string_view name :
       {"connection", "factsheet", "visualization", "order", "instantActions"}) {
    topics.names.push_back(name);
  }
  return WithListener(request.robot, environment, observer, std::move(topics),
                      [&](RobotListener& listener) {
                        return Test(request, listener, environment, consent, progress, observer);
                      });
}

}  // namespace fleetpub::app
