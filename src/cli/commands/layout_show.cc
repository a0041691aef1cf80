// `fleetpub layout show FILE`: what a layout holds.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>

#include "base/json_members.h"
#include "base/text.h"
#include "cli/layout_file.h"
#include "cli/output/table.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using base::Printable;
using base::Put;
using layout::Site;

// What one layout of the file holds.
struct Counted {
  std::uint32_t nodes = 0;
  std::uint32_t edges = 0;
  std::uint32_t stations = 0;
  std::set<std::string> maps;
  double min_x = std::numeric_limits<double>::infinity();
  double min_y = std::numeric_limits<double>::infinity();
  double max_x = -std::numeric_limits<double>::infinity();
  double max_y = -std::numeric_limits<double>::infinity();
};

std::vector<Counted> Count(const Site& site) {
  std::vector<Counted> all(site.layouts.size());
  for (const auto& node : site.nodes) {
    Counted& counted = all[node.layout];
    ++counted.nodes;
    counted.maps.insert(node.map_id);
    counted.min_x = std::min(counted.min_x, node.x);
    counted.min_y = std::min(counted.min_y, node.y);
    counted.max_x = std::max(counted.max_x, node.x);
    counted.max_y = std::max(counted.max_y, node.y);
  }
  for (const auto& edge : site.edges) ++all[edge.layout].edges;
  for (const auto& station : site.stations) ++all[station.layout].stations;
  return all;
}

std::string ListMaps(const Counted& counted) {
  std::vector<std::string> maps;
  for (const std::string& map : counted.maps) maps.push_back(Printable(map));
  return base::Join(maps, ", ");
}

std::vector<std::string> ListNodes(const Site& site, const layout::Station& station) {
  std::vector<std::string> nodes;
  for (const std::size_t node : station.nodes) nodes.push_back(site.nodes[node].id);
  return nodes;
}

void ShowText(const Site& site, Output& output) {
  std::vector<std::string> types = site.VehicleTypes();
  for (std::string& type : types) type = Printable(type);
  const auto show = [&](std::string_view name, const std::string& text) {
    if (!text.empty()) output.Line(fmt::format("{:<15}{}", name, text));
  };
  show("project", Printable(site.project));
  show("creator", Printable(site.creator));
  show("exported", Printable(site.exported));
  show("LIF", Printable(site.lif_version));
  show("vehicle types", types.empty() ? "none" : base::Join(types, ", "));

  const std::vector<Counted> counted = Count(site);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const Counted& c = counted[i];
    rows.push_back(
        {{Printable(site.layouts[i].id)},
         {Printable(site.layouts[i].level)},
         {std::to_string(c.nodes)},
         {std::to_string(c.edges)},
         {std::to_string(c.stations)},
         {c.nodes == 0 ? ""
                       : fmt::format("{:.1f} x {:.1f} m", c.max_x - c.min_x, c.max_y - c.min_y)},
         {ListMaps(c)}});
  }
  constexpr auto kLayouts = std::to_array<Column>({{"LAYOUT", 0, 12},
                                                   {"LEVEL", 3, 6},
                                                   {"NODES", 0, 0, true},
                                                   {"EDGES", 0, 0, true},
                                                   {"STATIONS", 0, 0, true},
                                                   {"EXTENT", 2},
                                                   {"MAPS", 1, 10}});
  output.PeopleLine("");
  PrintTable(kLayouts, rows, output);
  if (site.stations.empty()) return;
  rows.clear();
  for (const auto& station : site.stations) {
    rows.push_back({{Printable(station.id)},
                    {Printable(station.name)},
                    {Printable(base::Join(ListNodes(site, station), ", "))},
                    {Printable(site.layouts[station.layout].id)}});
  }
  constexpr auto kStations = std::to_array<Column>(
      {{"STATION", 0, 12}, {"NAME", 2, 10}, {"NODES", 0, 12}, {"LAYOUT", 1, 10}});
  output.PeopleLine("");
  PrintTable(kStations, rows, output);
}

void PutLayout(base::JsonWriter& json, const layout::Layout& layout, const Counted& c) {
  Put(json, "layoutId", layout.id);
  if (!layout.name.empty()) Put(json, "name", layout.name);
  Put(json, "version", layout.version);
  if (!layout.level.empty()) Put(json, "level", layout.level);
  if (!layout.origin.empty()) Put(json, "origin", layout.origin);
  Put(json, "nodes", c.nodes);
  Put(json, "edges", c.edges);
  Put(json, "stations", c.stations);
  base::PutText(json, "maps");
  json.StartArray();
  for (const std::string& map : c.maps) base::PutText(json, map);
  json.EndArray();
  if (c.nodes == 0) return;
  base::PutObject(json, "extent", [&] {
    Put(json, "minX", c.min_x);
    Put(json, "minY", c.min_y);
    Put(json, "maxX", c.max_x);
    Put(json, "maxY", c.max_y);
  });
}

void PutTexts(base::JsonWriter& json, std::string_view key, const std::vector<std::string>& texts) {
  base::PutText(json, key);
  json.StartArray();
  for (const std::string& text : texts) base::PutText(json, text);
  json.EndArray();
}

std::string ToJson(const Site& site) {
  base::JsonBuffer buffer;
  base::JsonWriter json(buffer);
  json.StartObject();
  Put(json, "project", site.project);
  Put(json, "creator", site.creator);
  Put(json, "exported", site.exported);
  Put(json, "lifVersion", site.lif_version);
  PutTexts(json, "vehicleTypes", site.VehicleTypes());
  const std::vector<Counted> counted = Count(site);
  std::size_t index = 0;
  base::PutArray(json, "layouts", site.layouts,
                 [&](const layout::Layout& layout) { PutLayout(json, layout, counted[index++]); });
  base::PutArray(json, "stations", site.stations, [&](const layout::Station& station) {
    Put(json, "stationId", station.id);
    if (!station.name.empty()) Put(json, "name", station.name);
    if (station.height) Put(json, "height", *station.height);
    PutTexts(json, "nodes", ListNodes(site, station));
    Put(json, "layoutId", site.layouts[station.layout].id);
  });
  json.EndObject();
  return buffer.GetString();
}

}  // namespace

Run DeclareLayoutShow(OptionSet& set) {
  const auto file = std::make_shared<std::string>();
  DeclareLayoutFile(set, *file);
  return [file](const Context& context) -> Result<ExitCode> {
    const auto site = LoadLayout(*file, context.output);
    if (!site) return Fail(site.error());
    if (context.output.json()) {
      context.output.Line(ToJson(*site));
    } else {
      ShowText(*site, context.output);
    }
    return ExitCode::kDone;
  };
}

}  // namespace fleetpub::cli
