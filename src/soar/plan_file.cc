#include "soar/plan_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/csv.h"
#include "base/json.h"
#include "base/text.h"

namespace fleetpub::soar {
namespace {

using base::FindMember;
using base::StringMember;
using base::ToView;
using rapidjson::SizeType;
using Value = base::JsonValue;
using Pair = std::pair<std::string_view, std::string_view>;

tl::unexpected<Error> Refuse(std::string what) {
  return Fail(ErrorKind::kInvalid, std::move(what));
}

bool IsBlank(std::string_view text) {
  return text.find_first_not_of(" \t") == std::string_view::npos;
}

// --- CSV

Status CheckColumns(const base::CsvRow& header) {
  for (const std::string& column : header.fields) {
    if (FindField(WaypointFields(), column) != nullptr) continue;
    std::vector<std::string> names;
    for (const Field& field : WaypointFields()) {
      names.emplace_back(field.short_names[0].empty() ? field.name : field.short_names[0]);
    }
    return Refuse(fmt::format("line {}: the column '{}' is not known: there are {}", header.line,
                              base::Printable(column.substr(0, 60)), base::Join(names, ", ")));
  }
  return {};
}

Result<Item> ReadWaypoint(const base::CsvRow& row, const base::CsvRow& header) {
  if (row.fields.size() != header.fields.size()) {
    return Refuse(fmt::format("line {}: it has {} fields, the header has {}", row.line,
                              row.fields.size(), header.fields.size()));
  }
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < row.fields.size(); ++i) {
    if (!IsBlank(row.fields[i])) pairs.emplace_back(header.fields[i], row.fields[i]);
  }
  auto item = ItemFrom(WaypointFields(), pairs);
  if (!item) return Refuse(fmt::format("line {}: {}", row.line, item.error().message));
  return item;
}

Result<PlanFile> FromCsv(std::string_view content) {
  auto rows = base::ParseCsv(content);
  if (!rows) return Fail(std::move(rows.error()));
  if (rows->empty()) {
    return Refuse("it is empty: a row of column names comes first, such as lat,lon,depth,action");
  }
  for (base::CsvRow& row : *rows) {
    if (&row != rows->data()) continue;
    for (std::string& column : row.fields) {
      column.erase(0, std::min(column.find_first_not_of(' '), column.size()));
      column.erase(column.find_last_not_of(' ') + 1);
    }
  }
  const base::CsvRow& header = rows->front();
  if (auto known = CheckColumns(header); !known) return Fail(known.error());
  PlanFile plan;
  for (std::size_t i = 1; i < rows->size(); ++i) {
    auto item = ReadWaypoint((*rows)[i], header);
    if (!item) return Fail(std::move(item.error()));
    plan.waypoints.push_back(*std::move(item));
  }
  return plan;
}

// --- JSON

Result<Item> ReadWaypoint(const Value& value) {
  if (!value.IsObject()) return Refuse("it must be an object");
  Item item;
  for (const auto& [name, member] : value.GetObject()) {
    const Field* field = FindField(WaypointFields(), ToView(name));
    if (field == nullptr) {
      item.push_back({std::string(ToView(name)), base::ToJson(member)});
      continue;
    }
    auto taken = TakeField(*field, member);
    if (!taken) return Fail(std::move(taken.error()));
    const bool twice = std::any_of(item.begin(), item.end(),
                                   [&](const Member& m) { return m.name == taken->name; });
    if (twice) return Refuse(fmt::format("{} is given twice", field->name));
    item.push_back(*std::move(taken));
  }
  if (auto complete = CheckComplete(WaypointFields(), item); !complete) {
    return Fail(complete.error());
  }
  return item;
}

Result<PlanFile> FromArray(const Value& array) {
  PlanFile plan;
  for (SizeType i = 0; i < array.Size(); ++i) {
    auto item = ReadWaypoint(array[i]);
    if (!item) return Refuse(fmt::format("waypoint {}: {}", i + 1, item.error().message));
    plan.waypoints.push_back(*std::move(item));
  }
  return plan;
}

// --- GeoJSON

bool IsPosition(const Value& value) {
  return value.IsArray() && value.Size() >= 2 &&
         std::all_of(value.Begin(), value.End(), [](const Value& v) { return v.IsNumber(); });
}

Result<PlanFile> FromLineString(const Value& geometry) {
  const Value* positions = FindMember(geometry, "coordinates");
  if (positions == nullptr || !positions->IsArray()) {
    return Refuse("the LineString has no array of coordinates");
  }
  PlanFile plan;
  bool has_height = false;
  for (SizeType i = 0; i < positions->Size(); ++i) {
    const Value& position = (*positions)[i];
    if (!IsPosition(position)) {
      return Refuse(
          fmt::format("waypoint {}: a position must be [longitude, latitude] in numbers, not {}",
                      i + 1, base::Printable(base::ToJson(position).substr(0, 60))));
    }
    has_height |= position.Size() > 2;
    plan.waypoints.push_back({{"latitude_waypoint", base::ToJson(position[1])},
                              {"longitude_waypoint", base::ToJson(position[0])}});
  }
  if (has_height) {
    plan.warnings.emplace_back(
        "the third number of a position is not sent: GeoJSON counts heights upwards from the "
        "ellipsoid; say depths with --each depth=...");
  }
  return plan;
}

bool IsLineString(const Value& value) { return StringMember(value, "type") == "LineString"; }

// The geometry of a Feature; else the value itself.
const Value& FindGeometry(const Value& value) {
  const Value* geometry =
      StringMember(value, "type") == "Feature" ? FindMember(value, "geometry") : nullptr;
  return geometry == nullptr ? value : *geometry;
}

Result<PlanFile> FromGeoJson(const Value& document) {
  const Value* features = FindMember(document, "features");
  if (features == nullptr) {
    if (IsLineString(FindGeometry(document))) return FromLineString(FindGeometry(document));
    return Refuse(fmt::format("a plan is read from a LineString, not from a {}",
                              base::Printable(StringMember(FindGeometry(document), "type"))));
  }
  const Value* line = nullptr;
  SizeType lines = 0;
  for (SizeType i = 0; features->IsArray() && i < features->Size(); ++i) {
    if (!IsLineString(FindGeometry((*features)[i]))) continue;
    line = &FindGeometry((*features)[i]);
    ++lines;
  }
  if (lines == 1) return FromLineString(*line);
  return Refuse(
      fmt::format("the FeatureCollection has {} LineStrings: a plan is read from one", lines));
}

Result<PlanFile> FromJson(std::string_view content) {
  auto document = base::ParseJson(content);
  if (!document) return Fail(std::move(document.error()));
  if (document->IsArray()) return FromArray(*document);
  const Value* plan = FindMember(*document, "plan");
  if (plan != nullptr && plan->IsArray()) return FromArray(*plan);
  if (FindMember(*document, "type") != nullptr) return FromGeoJson(*document);
  return Refuse(
      "it must be an array of waypoints, an object with such an array as plan, or GeoJSON");
}

}  // namespace

Result<PlanFile> ReadPlan(std::string_view content, std::string_view name) {
  const auto first = content.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool braced =
      first != std::string_view::npos && (content[first] == '{' || content[first] == '[');
  const bool is_csv = base::ToLower(name).ends_with(".csv") || !braced;
  auto plan = is_csv ? FromCsv(content) : FromJson(content);
  if (plan) return plan;
  const std::string shown = name == "-" ? "standard input" : base::Printable(name);
  return Refuse(fmt::format("{}: {}", shown, plan.error().message));
}

}  // namespace fleetpub::soar
