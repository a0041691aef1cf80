#include "app/path_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/csv.h"
#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::app {
namespace {

using base::Printable;
using vda5050::OrderPosition;

// A person who types height=1.2 for a predefined action means a number.
Result<vda5050::Parameter> ParseTyped(std::string_view type, const std::string& text) {
  const auto equals = text.find('=');
  if (equals != std::string::npos && equals > 0 && text[equals - 1] != ':') {
    const std::string_view key = std::string_view(text).substr(0, equals);
    for (const auto& spec : vda5050::ParametersInAnyVersion(type)) {
      if (spec.name == key) return ParseParameter(spec, std::string_view(text).substr(equals + 1));
    }
  }
  return vda5050::ParseAssignment(text);
}

struct PathColumns {
  std::optional<std::size_t> node, x, y, theta, map, actions;
};

Result<PathColumns> ReadColumns(const base::CsvRow& header) {
  PathColumns columns;
  const std::pair<std::string_view, std::optional<std::size_t>*> known[] = {
      {"node", &columns.node},   {"x", &columns.x},     {"y", &columns.y},
      {"theta", &columns.theta}, {"map", &columns.map}, {"actions", &columns.actions}};
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const std::string_view name = base::Trimmed(header.fields[i]);
    const auto* const found = std::find_if(std::begin(known), std::end(known),
                                           [&](const auto& k) { return k.first == name; });
    if (found == std::end(known) || *found->second) {
      return Fail(
          ErrorKind::kInvalid,
          fmt::format("line {}: column '{}' is {}: node, x, y, theta, map, actions", header.line,
                      Printable(name), found == std::end(known) ? "none of" : "there twice, of"));
    }
    *found->second = i;
  }
  if (!columns.node) {
    return Fail(
        ErrorKind::kInvalid,
        fmt::format("line {}: a column node is missing: node,x,y,theta,map,actions", header.line));
  }
  return columns;
}

class RowReader {
 public:
  RowReader(const base::CsvRow& row, const PathColumns& columns) : row_(row), columns_(columns) {}

  Result<PathPoint> Read() {
    PathPoint point{.node = std::string(Cell(columns_.node)), .position = {}, .actions = {}};
    if (point.node.empty()) return Refuse("the node has no name");
    const bool has_place = !Cell(columns_.x).empty() || !Cell(columns_.y).empty();
    if (has_place) {
      OrderPosition position{.map_id = std::string(Cell(columns_.map))};
      if (position.map_id.empty()) return Refuse("a node with x and y needs a map too");
      position.x = Number(columns_.x, "x");
      position.y = Number(columns_.y, "y");
      if (!Cell(columns_.theta).empty()) position.theta = Number(columns_.theta, "theta");
      if (position.theta && std::abs(*position.theta) > vda5050::kMaxAngle) {
        return Refuse("theta lies beyond ±π: it is in radians");
      }
      point.position = std::move(position);
    }
    if (!fault_.empty()) return Refuse(fault_);
    for (const std::string& text : base::Split(Cell(columns_.actions), ';')) {
      if (base::Trimmed(text).empty()) continue;
      auto words = base::Split(base::Trimmed(text), ' ');
      std::erase(words, "");
      auto action =
          ParsePlacedAction(words.front() + "@" + point.node, {words.begin() + 1, words.end()});
      if (!action) return Refuse(action.error().message);
      point.actions.push_back(*std::move(action));
    }
    return point;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Refuse(std::string_view what) const {
    return Fail(ErrorKind::kInvalid, fmt::format("line {}: {}", row_.line, what));
  }

  [[nodiscard]] std::string_view Cell(std::optional<std::size_t> column) const {
    if (!column || *column >= row_.fields.size()) return {};
    return base::Trimmed(row_.fields[*column]);
  }

  double Number(std::optional<std::size_t> column, std::string_view name) {
    const std::string_view text = Cell(column);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fault_ = fmt::format("{} must be a number, and '{}' is none", name, Printable(text));
    }
    return value;
  }

  const base::CsvRow& row_;
  const PathColumns& columns_;
  std::string fault_;
};

}  // namespace

Result<PlacedAction> ParsePlacedAction(std::string_view word,
                                       const std::vector<std::string>& parameters) {
  const auto at = word.find('@');
  if (at == std::string_view::npos || at == 0 || at + 1 == word.size()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("'{}' names no action and place, as in --action pick@n7 loadType=EPAL",
                            Printable(word)));
  }
  PlacedAction action{
      .type = std::string(vda5050::ActionCalled(word.substr(0, at)).value_or(word.substr(0, at))),
      .place = std::string(word.substr(at + 1)),
      .parameters = {}};
  for (const std::string& text : parameters) {
    auto parameter = ParseTyped(action.type, text);
    if (!parameter) return Fail(std::move(parameter.error()));
    for (const vda5050::Parameter& other : action.parameters) {
      if (other.key != parameter->key) continue;
      return Fail(ErrorKind::kUsage,
                  fmt::format("parameter '{}' is given twice", Printable(other.key)));
    }
    action.parameters.push_back(*std::move(parameter));
  }
  return action;
}

Result<std::vector<PathPoint>> ParsePathFile(std::string_view text) {
  const auto rows = base::ParseCsv(text);
  if (!rows) return Fail(rows.error());
  if (rows->size() < 2) {
    return Fail(ErrorKind::kInvalid,
                "it names no node: a row of column names comes first, node,x,y,theta,map,actions");
  }
  const auto columns = ReadColumns(rows->front());
  if (!columns) return Fail(columns.error());
  std::vector<PathPoint> points;
  for (std::size_t i = 1; i < rows->size(); ++i) {
    auto point = RowReader((*rows)[i], *columns).Read();
    if (!point) return Fail(std::move(point.error()));
    points.push_back(*std::move(point));
  }
  return points;
}

}  // namespace fleetpub::app
