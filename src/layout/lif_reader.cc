// Reads the Layout Interchange Format: 1.0 (and 0.11, which is alike), whose root has `layouts`, and
// 2.0, whose root has `origins`. The version that a file says it has decides nothing: published
// examples say a wrong one.
#include <fmt/format.h>

#include <charconv>
#include <unordered_map>
#include <utility>

#include "base/file.h"
#include "base/text.h"
#include "base/time.h"
#include "layout/layout.h"
#include "layout/lif_fields.h"
#include "layout/lif_properties.h"

namespace fleetpub::layout {
namespace {

using base::JsonValue;

constexpr Terms kTerms1 = {
    .major = 1,
    .project = "projectIdentification",
    .layout_description = "layoutDescription",
    .node_description = "nodeDescription",
    .edge_description = "edgeDescription",
    .station_description = "stationDescription",
    .action_description = "actionDescription",
    .node_properties = "vehicleTypeNodeProperties",
    .edge_properties = "vehicleTypeEdgeProperties",
    .max_speed = "maxSpeed",
    .max_rotation_speed = "maxRotationSpeed",
    .min_height = "minHeight",
    .max_height = "maxHeight",
};
constexpr Terms kTerms2 = {
    .major = 2,
    .project = "lifId",
    .layout_description = "layoutDescriptor",
    .node_description = "nodeDescriptor",
    .edge_description = "edgeDescriptor",
    .station_description = "stationDescriptor",
    .action_description = "actionDescriptor",
    .node_properties = "mobileRobotTypeNodeProperties",
    .edge_properties = "mobileRobotTypeEdgeProperties",
    .max_speed = "maximumSpeed",
    .max_rotation_speed = "maximumRotationSpeed",
    .min_height = "minimumLoadHandlingDeviceHeight",
    .max_height = "maximumMobileRobotHeight",
};

using Ids = std::unordered_map<std::string_view, std::size_t>;

class Reader {
 public:
  Reader(const Terms& terms, Site& site) : terms_(terms), site_(site) {}

  void Read(const JsonValue& root, FindingLog& log) {
    const Place top;
    Fields fields(root, top, log);
    if (const JsonValue* const meta = fields.TakeObject("metaInformation")) {
      ReadMeta(*meta, fields.At("metaInformation"), log);
    } else {
      log.Warn(top, "metaInformation is missing");
    }
    EachLayout(fields, Reading::kOnce,
               [&](Fields& layout, std::string_view origin) { ReadLayout(layout, origin); });
    fields.Finish();
    // An edge may lead to a node of any layout.
    layout_ = 0;
    EachLayout(fields, Reading::kAgain, [&](Fields& layout, std::string_view /*origin*/) {
      ReadConnections(layout);
      ++layout_;
    });
  }

 private:
  template <class Read>
  void EachLayout(Fields& root, Reading reading, Read read) {
    if (terms_.major == 1) {
      EachObject(
          root, "layouts", true, [&](Fields& layout, std::size_t) { read(layout, ""); }, reading);
      return;
    }
    const auto read_origin = [&](Fields& origin, std::size_t /*index*/) {
      const JsonValue* const id = origin.Take("originId");
      if (reading == Reading::kOnce) {
        static_cast<void>(origin.TakeText("originId", true));
        origin.Take("originDescriptor");
      }
      const std::string_view text = id != nullptr && id->IsString() ? base::ToView(*id) : "";
      EachObject(
          origin, "layouts", reading == Reading::kOnce,
          [&](Fields& layout, std::size_t) { read(layout, text); }, reading);
    };
    EachObject(root, "origins", true, read_origin, reading);
  }

  void ReadMeta(const JsonValue& value, const Place& place, FindingLog& log) {
    Fields fields(value, place, log);
    site_.project = fields.TakeText(terms_.project);
    site_.creator = fields.TakeText("creator");
    site_.exported = fields.TakeText("exportTimestamp");
    site_.lif_version = fields.TakeText("lifVersion");
    if (!site_.exported.empty() && !base::ParseDateTime(site_.exported)) {
      log.Warn(fields.At("exportTimestamp"),
               fmt::format("'{}' is no time such as 2026-04-15T11:40:03.12Z",
                           base::Printable(site_.exported)));
    }
    const std::string major = site_.lif_version.substr(0, site_.lif_version.find('.'));
    const bool is_known = terms_.major == 1 ? major == "1" || major == "0" : major == "2";
    if (!site_.lif_version.empty() && !is_known) {
      log.Warn(fields.At("lifVersion"),
               fmt::format("says {}, but the file is built like {}.x",
                           base::Printable(site_.lif_version), terms_.major));
    }
    fields.Finish();
  }

  // Whether the id is there and new. Its characters are those that VDA 5050 recommends (§6.1).
  static bool TakeId(Fields& fields, std::string_view name, Ids& known, std::size_t index,
                     std::string& id) {
    id = fields.TakeText(name, true);
    if (id.empty()) return false;
    constexpr std::string_view kRecommended =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.:";
    if (id.find_first_not_of(kRecommended) != std::string::npos) {
      fields.log().Warn(fields.At(name),
                        fmt::format("'{}' has characters other than A-Z a-z 0-9 _ - . :, which "
                                    "robots may refuse",
                                    base::Printable(id)));
    }
    if (known.emplace(base::ToView(*fields.Take(name)), index).second) return true;
    fields.Error(name, fmt::format("'{}' is the id of another one too", base::Printable(id)));
    return false;
  }

  void ReadLayout(Fields& fields, std::string_view origin) {
    Layout layout;
    static_cast<void>(TakeId(fields, "layoutId", layout_ids_, site_.layouts.size(), layout.id));
    layout.name = fields.TakeText("layoutName");
    layout.version = fields.TakeText("layoutVersion", true);
    layout.level = fields.TakeText("layoutLevelId");
    layout.description = fields.TakeText(terms_.layout_description);
    layout.origin = origin;
    layout.place = fields.place().ToString();
    Reserve(fields.Take("nodes"), node_ids_, site_.nodes);
    Reserve(fields.TakeArray("edges", true), edge_ids_, site_.edges);
    fields.Take("stations");
    EachObject(fields, "nodes", true,
               [&](Fields& node, std::size_t index) { ReadNode(node, index); });
    site_.layouts.push_back(std::move(layout));
  }

  template <class Elements>
  static void Reserve(const JsonValue* array, Ids& ids, Elements& elements) {
    if (array == nullptr || !array->IsArray()) return;
    ids.reserve(ids.size() + array->Size());
    elements.reserve(elements.size() + array->Size());
  }

  void ReadNode(Fields& fields, std::size_t index) {
    Node node;
    const bool is_new = TakeId(fields, "nodeId", node_ids_, site_.nodes.size(), node.id);
    node.name = fields.TakeText("nodeName");
    node.description = fields.TakeText(terms_.node_description);
    node.map_id = fields.TakeText("mapId", true);
    node.layout = site_.layouts.size();
    node.index = static_cast<std::uint32_t>(index);
    bool has_position = false;
    if (const JsonValue* const position = fields.TakeObject("nodePosition")) {
      const Place place = fields.At("nodePosition");
      Fields inner(*position, place, fields.log());
      const auto x = inner.TakeNumber("x", true);
      const auto y = inner.TakeNumber("y", true);
      inner.Finish();
      has_position = x && y;
      node.x = x.value_or(0);
      node.y = y.value_or(0);
    } else {
      fields.log().Error(fields.place(), "nodePosition is missing");
    }
    node.properties = ReadNodeProperties(fields, terms_);
    if (!has_position) node.properties.clear();  // no vehicle is sent there
    if (is_new) site_.nodes.push_back(std::move(node));
  }

  void ReadConnections(Fields& fields) {
    EachObject(fields, "edges", false,
               [&](Fields& edge, std::size_t index) { ReadEdge(edge, index); });
    EachObject(fields, "stations", false,
               [&](Fields& station, std::size_t index) { ReadStation(station, index); });
  }

  // The node of this id. An error where there is none.
  std::optional<std::size_t> FindNode(const std::string& id, std::string_view name,
                                      Fields& fields) {
    if (id.empty()) return std::nullopt;
    if (const auto found = node_ids_.find(id); found != node_ids_.end()) return found->second;
    fields.Error(name, fmt::format("there is no node '{}'", base::Printable(id)));
    return std::nullopt;
  }

  void ReadEdge(Fields& fields, std::size_t index) {
    Edge edge;
    const bool is_new = TakeId(fields, "edgeId", edge_ids_, site_.edges.size(), edge.id);
    edge.name = fields.TakeText("edgeName");
    edge.description = fields.TakeText(terms_.edge_description);
    edge.layout = layout_;
    edge.index = static_cast<std::uint32_t>(index);
    const auto start = FindNode(fields.TakeText("startNodeId", true), "startNodeId", fields);
    const auto end = FindNode(fields.TakeText("endNodeId", true), "endNodeId", fields);
    if (start && site_.nodes[*start].layout != layout_) {
      fields.Error("startNodeId",
                   fmt::format("'{}' is a node of another layout: an edge belongs to that of its "
                               "start",
                               base::Printable(site_.nodes[*start].id)));
    }
    edge.properties = ReadEdgeProperties(fields, terms_);
    if (!is_new || !start || !end) return;
    edge.start = *start;
    edge.end = *end;
    site_.edges.push_back(std::move(edge));
  }

  // A number, or a text that holds one.
  static std::optional<double> TakeHeight(Fields& fields) {
    const JsonValue* const value = fields.Take("stationHeight");
    if (value == nullptr || !value->IsString()) return fields.TakeNonNegative("stationHeight");
    const std::string_view text = base::ToView(*value);
    double height = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), height);
    const bool is_number = error == std::errc() && end == text.data() + text.size();
    if (!is_number || !(height >= 0 && height < 1e6)) {
      fields.Error("stationHeight",
                   fmt::format("must be a number, not '{}'", base::Printable(text)));
      return std::nullopt;
    }
    fields.log().Warn(fields.At("stationHeight"), "is a number in quotation marks");
    return height;
  }

  void ReadStation(Fields& fields, std::size_t index) {
    Station station;
    const bool is_new =
        TakeId(fields, "stationId", station_ids_, site_.stations.size(), station.id);
    station.name = fields.TakeText("stationName");
    station.description = fields.TakeText(terms_.station_description);
    station.height = TakeHeight(fields);
    if (terms_.major == 1 && !station.height) station.height = 0;
    if (terms_.major > 1) station.type = fields.TakeText("stationType");
    station.layout = layout_;
    station.index = static_cast<std::uint32_t>(index);
    if (const JsonValue* const position = fields.TakeObject("stationPosition")) {
      const Place place = fields.At("stationPosition");
      Fields inner(*position, place, fields.log());
      const auto x = inner.TakeNumber("x", true);
      const auto y = inner.TakeNumber("y", true);
      const auto theta = inner.TakeAngle("theta");
      inner.Finish();
      if (x && y) station.position = StationPosition{*x, *y, theta};
    }
    const bool has_nodes = fields.TakeArray("interactionNodeIds", true) != nullptr;
    const auto ids = fields.TakeTexts("interactionNodeIds");
    for (const std::string& id : ids) {
      if (const auto node = FindNode(id, "interactionNodeIds", fields)) {
        station.nodes.push_back(*node);
      }
    }
    if (has_nodes && ids.empty()) {
      fields.Error("interactionNodeIds", "must not be empty: where is it used from?");
    }
    if (is_new) site_.stations.push_back(std::move(station));
  }

  const Terms& terms_;
  Site& site_;
  Ids layout_ids_;
  Ids node_ids_;
  Ids edge_ids_;
  Ids station_ids_;
  std::size_t layout_ = 0;  // whose edges are read
};

Result<base::JsonDocument> Parse(std::string_view text) {
  return base::ParseJson(text, {.bytes = base::kMaxFileBytes});
}

Result<ReadSite> ReadDocument(const Result<base::JsonDocument>& document) {
  if (!document) return Fail(document.error());
  const auto refuse = [](std::string_view why) {
    return Fail(ErrorKind::kInvalid, fmt::format("no layout (LIF): {}", why));
  };
  if (!document->IsObject()) {
    return refuse(fmt::format("it is {}, not an object", NameOfType(*document)));
  }
  const bool is_1 = base::FindMember(*document, "layouts") != nullptr;
  const bool is_2 = base::FindMember(*document, "origins") != nullptr;
  if (is_1 == is_2) {
    return refuse(is_1 ? "it has layouts and origins, and should have one of them"
                       : "it has neither layouts (1.0) nor origins (2.0)");
  }
  ReadSite read;
  FindingLog log;
  Reader(is_1 ? kTerms1 : kTerms2, read.site).Read(*document, log);
  read.findings = log.Take();
  if (read.site.layouts.empty()) return refuse("there is no layout in it");
  return read;
}

}  // namespace

Result<ReadSite> ReadLayout(std::string_view text) { return ReadDocument(Parse(text)); }

Result<ReadSite> ReadLayoutFile(const std::string& file) {
  auto text = base::ReadFile(file);
  if (!text) return Fail(text.error());
  const auto document = Parse(*text);
  std::string().swap(*text);  // a site of 10,000 nodes may take 20 MB of it
  auto read = ReadDocument(document);
  if (!read) {
    const std::string name = file == "-" ? "standard input" : base::Printable(file);
    read.error().message.insert(0, name + ": ");
  }
  return read;
}

}  // namespace fleetpub::layout
