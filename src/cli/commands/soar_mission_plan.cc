// `fleetpub soar mission-plan DESTINATION`: waypoints from options or a file.
#include <fmt/format.h>

#include <memory>

#include "base/file.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/soar_sending.h"
#include "soar/plan_file.h"

namespace fleetpub::cli {
namespace {

struct SoarMissionPlanOptions {
  FieldOptions fields;
  std::vector<std::string> waypoints;
  std::string file;
  std::string each;
  SoarSendingOptions sending;
};

Result<soar::PlanFile> PlanFromOptions(const std::vector<std::string>& texts) {
  soar::PlanFile plan;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    auto item = soar::ParseItem(soar::WaypointFields(), texts[i]);
    if (!item) {
      return Fail(ErrorKind::kUsage, fmt::format("waypoint {}: {}", i + 1, item.error().message));
    }
    plan.waypoints.push_back(*std::move(item));
  }
  return plan;
}

Result<soar::PlanFile> ReadPlanFile(const SoarMissionPlanOptions& options) {
  if (options.file.empty() == options.waypoints.empty()) {
    return Fail(ErrorKind::kUsage, options.file.empty()
                                       ? "a plan needs waypoints: give them with --waypoint, or a "
                                         "file of them with --plan"
                                       : "--waypoint and --plan exclude each other");
  }
  if (options.file.empty()) return PlanFromOptions(options.waypoints);
  const auto content = base::ReadFile(options.file);
  if (!content) return Fail(content.error());
  return soar::ReadPlan(*content, options.file);
}

Result<ExitCode> RunMissionPlan(const SoarMissionPlanOptions& options, const Context& context) {
  context.output.Reads(options.file);
  auto plan = ReadPlanFile(options);
  if (!plan) return Fail(std::move(plan.error()));
  if (!options.each.empty()) {
    const auto defaults =
        soar::ParseItem(soar::WaypointFields(), options.each, soar::Completeness::kPart);
    if (!defaults) return Fail(ErrorKind::kUsage, "--each: " + defaults.error().message);
    soar::AddDefaults(*defaults, plan->waypoints);
  }
  auto members = options.fields.Members();
  if (!members) return Fail(std::move(members.error()));
  members->push_back({"plan", soar::ItemsJson(plan->waypoints)});
  for (const std::string& warning : plan->warnings) context.output.Warn(warning);
  constexpr auto kType = soar::MessageType::kMissionPlan;
  return SendSoarMessage(options.sending, kType, soar::BuildPayload(kType, *members), context);
}

}  // namespace

Run DeclareSoarMissionPlan(OptionSet& set) {
  constexpr const char* kPayload = "Payload";
  const auto options = std::make_shared<SoarMissionPlanOptions>();
  options->fields.Declare(set, soar::ListFields(soar::MessageType::kMissionPlan));
  set.AddOption("--waypoint", options->waypoints,
                "A waypoint: lat=50.37,lon=-4.19 and what else there is to say: depth, altitude, "
                "action, activate_payload, send_environmental_data, flight_style; one each")
      .Type("LIST")
      .OneValueEach()
      .Group(kPayload);
  set.AddOption("--plan", options->file,
                "Waypoints from a file instead: CSV with a header row, JSON, or a GeoJSON "
                "LineString; - is standard input")
      .Type("FILE")
      .Group(kPayload);
  set.AddOption("--each", options->each, "For waypoints that do not say: depth=15,action=move")
      .Type("LIST")
      .Group(kPayload);
  DeclareSoarSending(set, options->sending);
  return [options](const Context& context) { return RunMissionPlan(*options, context); };
}

}  // namespace fleetpub::cli
