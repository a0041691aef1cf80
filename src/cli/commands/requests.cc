// `fleetpub requests [PATTERN]`: what robots ask fleet control for (VDA 5050 3.0 §6.4.3).
#include <fmt/format.h>

#include <array>
#include <memory>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/table.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using vda5050::RobotRequest;
using vda5050::Shown;

std::string RequestJson(std::string_view target, const RobotRequest& request) {
  std::string json = fmt::format(
      R"({{"target":{},"requestId":{},"requestType":{},"requestStatus":{})", JsonString(target),
      JsonString(request.id), JsonString(request.type), JsonString(request.status));
  const auto add = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) json += fmt::format(R"(,"{}":{})", key, JsonString(value));
  };
  add("zoneId", request.zone_id);
  add("zoneSetId", request.zone_set_id);
  add("edgeId", request.edge_id);
  if (request.sequence_id) {
    json += fmt::format(R"(,"sequenceId":{})", *request.sequence_id);
  } else if (!request.edge_id.empty()) {
    json += R"(,"sequenceId":"unknown")";  // no null, which jq takes for less than every number
  }
  return json + "}";
}

std::string About(const RobotRequest& request) {
  if (request.edge_id.empty()) {
    return fmt::format("zone {} of {}", Shown(request.zone_id), Shown(request.zone_set_id));
  }
  const std::string place =
      request.sequence_id ? fmt::format(" at {}", *request.sequence_id) : std::string();
  return fmt::format("edge {}{}", Shown(request.edge_id), place);
}

void ShowRequests(const std::vector<Row>& rows, Output& output) {
  if (output.json()) return;
  if (rows.empty()) return output.PeopleLine("no robot that sent a state asks for anything");
  constexpr std::array kColumns = {Column{.name = "ROBOT", .least = 16}, Column{.name = "REQUEST"},
                                   Column{.name = "TYPE", .rank = 1},
                                   Column{.name = "ABOUT", .least = 16}, Column{.name = "STATUS"}};
  PrintTable(kColumns, rows, output);
}

Result<ExitCode> RunRequests(const FleetDiscoveryOptions& options, const Context& context) {
  auto asked = ParseFleetOptions(options);
  if (!asked) return Fail(asked.error());
  const auto environment = MakeEnvironment(context, options.from, delivery::Play::kLast);
  const auto fleet = app::DiscoverFleet(*std::move(asked), environment, {}, context.output);
  if (!fleet) return Fail(fleet.error());
  std::vector<Row> rows;
  for (const app::ListedRobot* robot : fleet->robots()) {
    const auto& [address, entry] = *robot;
    if (!entry.state) continue;
    const std::string target = address.ToString();
    for (const RobotRequest& request : entry.state->requests) {
      if (context.output.json()) {
        context.output.Line(RequestJson(target, request));
      } else {
        rows.push_back({{base::Printable(target)},
                        {Shown(request.id)},
                        {Shown(request.type)},
                        {About(request)},
                        {Shown(request.status)}});
      }
    }
  }
  ShowRequests(rows, context.output);
  TellRecording(environment, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareRequests(OptionSet& set) {
  const auto options = std::make_shared<FleetDiscoveryOptions>();
  // Requests stand in states only, which a robot may send no more often than every 30 s.
  options->state_wait = vda5050::kLongestSilence;
  DeclareFleetDiscoveryOptions(set, *options);
  return [options](const Context& context) { return RunRequests(*options, context); };
}

}  // namespace fleetpub::cli
