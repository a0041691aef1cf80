// `fleetpub layout route FILE --from n1 --to dock-3`: the cheapest way for a vehicle.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "base/json_members.h"
#include "base/text.h"
#include "cli/layout_file.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "layout/route.h"

namespace fleetpub::cli {
namespace {

using base::Printable;
using layout::Route;
using layout::RouteCost;
using layout::Site;

struct LayoutRouteOptions {
  std::string file;
  std::string from;
  std::string to;
  std::vector<std::string> via;
  std::string vehicle_type;
  bool loaded = false;
  std::string load_set;
  RouteCost cost = RouteCost::kLength;
  std::optional<double> speed;
  std::optional<double> heading;

  [[nodiscard]] std::vector<std::string> Stops() const {
    std::vector<std::string> stops = via;
    stops.push_back(to);
    return stops;
  }
};

ValueKind Number(std::optional<double>& value, std::string_view type, double least, double most) {
  return {type,
          internal::StoreOne(
              value, [=](const std::string& t) { return ParseBetween<double>(t, least, most); }),
          [=] { return fmt::format("a number from {} to {}", least, most); }};
}

Result<layout::RouteRequest> MakeRequest(const LayoutRouteOptions& o, const Site& site) {
  if (o.from.empty() || o.to.empty()) {
    return Fail(ErrorKind::kUsage, "a route needs --from and --to: nodes or stations");
  }
  auto type = layout::ChooseVehicleType(site, o.vehicle_type, "");
  if (!type) return Fail(std::move(type.error()));
  layout::RouteRequest request{.vehicle_type = *std::move(type),
                               .loaded = o.loaded || !o.load_set.empty(),
                               .load_set = o.load_set,
                               .cost = o.cost,
                               .vehicle_speed = o.speed,
                               .heading = o.heading};
  const auto from = layout::ResolvePlace(site, o.from);
  if (!from) return Fail(from.error());
  if (from->size() > 1) {
    std::vector<std::string> nodes;
    for (const std::size_t node : *from) nodes.push_back(Printable(site.nodes[node].id));
    return Fail(ErrorKind::kUsage, fmt::format("--from: station {} has several nodes, name one: {}",
                                               Printable(o.from), base::Join(nodes, ", ")));
  }
  request.from = from->front();
  for (const std::string& word : o.Stops()) {
    auto nodes = layout::ResolvePlace(site, word);
    if (!nodes) return Fail(std::move(nodes.error()));
    request.stops.push_back(*std::move(nodes));
  }
  return request;
}

// Those that always go along.
std::size_t CountActions(const Site& site, const Route& route, const std::string& type) {
  std::size_t count = 0;
  const auto add = [&](const auto& element) {
    const auto* const properties = element.Find(type);
    if (properties == nullptr) return;
    count += static_cast<std::size_t>(std::count_if(
        properties->actions.begin(), properties->actions.end(),
        [](const auto& action) { return action.requirement == layout::Requirement::kRequired; }));
  };
  for (const std::size_t node : route.nodes) add(site.nodes[node]);
  for (const auto& edge : route.edges) add(site.edges[edge.edge]);
  return count;
}

// A station is named behind its node.
std::string ToText(const LayoutRouteOptions& o, const Site& site, const Route& route,
                   const std::string& type) {
  const auto words = o.Stops();
  std::string text;
  for (std::size_t i = 0; i < route.nodes.size(); ++i) {
    const std::string& id = site.nodes[route.nodes[i]].id;
    text += (i == 0 ? "" : " → ") + Printable(id);
    for (std::size_t stop = 0; stop < route.stops.size(); ++stop) {
      const bool is_station = route.stops[stop] == i && words[stop] != id;
      if (is_station) text += fmt::format(" ({})", Printable(words[stop]));
    }
  }
  text += fmt::format(", {:.1f} m", route.length);
  if (o.cost == RouteCost::kTime) text += fmt::format(", {:.0f} s", route.seconds);
  if (const auto actions = CountActions(site, route, type); actions > 0) {
    text += ", " + base::Counted(actions, "action");
  }
  return text;
}

std::string ToJson(const LayoutRouteOptions& o, const Site& site, const Route& route,
                   const std::string& type) {
  base::JsonBuffer buffer;
  base::JsonWriter json(buffer);
  json.StartObject();
  base::PutText(json, "nodes");
  json.StartArray();
  for (const std::size_t node : route.nodes) base::PutText(json, site.nodes[node].id);
  json.EndArray();
  base::PutText(json, "edges");
  json.StartArray();
  for (const auto& edge : route.edges) base::PutText(json, site.edges[edge.edge].id);
  json.EndArray();
  base::Put(json, "length", route.length);
  base::Put(json, "seconds", route.seconds);
  base::Put(json, "vehicleType", type);
  base::Put(json, "actions", static_cast<std::uint32_t>(CountActions(site, route, type)));
  const auto words = o.Stops();
  std::size_t index = 0;
  base::PutArray(json, "stops", route.stops, [&](std::size_t position) {
    base::Put(json, "place", words[index++]);
    base::Put(json, "node", site.nodes[route.nodes[position]].id);
  });
  json.EndObject();
  return buffer.GetString();
}

Result<ExitCode> RunRoute(const LayoutRouteOptions& o, const Context& context) {
  const auto site = LoadLayout(o.file, context.output);
  if (!site) return Fail(site.error());
  const auto request = MakeRequest(o, *site);
  if (!request) return Fail(request.error());
  const auto route = layout::FindRoute(*site, *request);
  if (!route) return Fail(route.error());
  Output& output = context.output;
  if (output.json()) {
    output.Line(ToJson(o, *site, *route, request->vehicle_type));
  } else {
    output.Line(WrappedFor(STDOUT_FILENO, ToText(o, *site, *route, request->vehicle_type)));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareLayoutRoute(OptionSet& set) {
  const auto options = std::make_shared<LayoutRouteOptions>();
  LayoutRouteOptions& o = *options;
  DeclareLayoutFile(set, o.file);
  const auto add = [&](const char* names, ValueKind kind, const char* help) {
    return set.AddOption(names, std::move(kind), help).Group("Route");
  };
  add("--from", Text(o.from), "Where it begins: a node, or a station with one node").Type("PLACE");
  add("--to", Text(o.to), "Where it ends: a node, or a station by id or name").Type("PLACE");
  add("--via", Text(o.via), "Where it leads through; repeatable, in this order")
      .Type("PLACE")
      .OneValueEach();
  add("--vehicle-type", Text(o.vehicle_type), "For which vehicles [the only type of the layout]")
      .Type("TYPE");
  set.AddFlag("--loaded", o.loaded, "The vehicle carries a load").Group("Route");
  add("--load-set", Text(o.load_set), "The set of the load, as the factsheet names it; is loaded")
      .Type("NAME");
  add("--by", OneOf(o.cost, layout::kRouteCosts), "What counts: {} [length]");
  add("--speed", Number(o.speed, "M/S", 0.01, 100),
      "The vehicle's own speed, for --by time [as fast as edges allow, else 1]");
  add("--heading", Number(o.heading, "RAD", -3.15, 3.15), "In which it stands at the beginning");
  return [options](const Context& context) { return RunRoute(*options, context); };
}

}  // namespace fleetpub::cli
