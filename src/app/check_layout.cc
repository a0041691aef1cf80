#include "app/check_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {
namespace {

using base::Printable;
using layout::LayoutFinding;
using layout::Site;

class Findings {
 public:
  explicit Findings(std::vector<LayoutFinding>& findings) : findings_(findings) {}

  void Warn(std::string place, std::string text) {
    // Several vehicle types of one element follow each other.
    for (auto other = findings_.rbegin(); other != findings_.rend(); ++other) {
      if (other->place != place) break;
      if (other->text == text) return;
    }
    findings_.push_back({LayoutFinding::Level::kWarning, std::move(place), std::move(text)});
  }

 private:
  std::vector<LayoutFinding>& findings_;
};

struct Spot {
  std::string place;
  bool is_node;
};

// Parameters that the fleet control adds when it knows the load and the station are not expected in a
// file; what no order can do without is.
void CheckAction(const layout::LayoutAction& action, const Spot& spot, vda5050::Version version,
                 Findings& findings) {
  const auto* const spec = vda5050::FindAction(version, action.type);
  const std::string_view release = vda5050::GetFacts(version).name;
  if (spec == nullptr) {
    const auto known = vda5050::ActionCalled(action.type);
    if (!known) return;  // a manufacturer's own
    const std::string_view own = vda5050::NameIn(version, *known);
    findings.Warn(spot.place, own != action.type && vda5050::FindAction(version, own) != nullptr
                                  ? fmt::format("action {}: version {} calls it {}",
                                                Printable(action.type), release, own)
                                  : fmt::format("action {} does not exist in version {}",
                                                Printable(action.type), release));
    return;
  }
  if (!(spot.is_node ? spec->scopes.node : spec->scopes.edge)) {
    findings.Warn(spot.place, fmt::format("action {} is none for {} in version {}", action.type,
                                          spot.is_node ? "a node" : "an edge", release));
  }
  for (const auto& parameter : spec->parameters) {
    const bool is_given =
        std::any_of(action.parameters.begin(), action.parameters.end(),
                    [&](const auto& given) { return given.key == parameter.name; });
    if (parameter.required && !is_given) {
      findings.Warn(spot.place, fmt::format("action {} is without its parameter {}", action.type,
                                            parameter.name));
    }
  }
}

// Calls `visit(properties, spot)` for all that is said of nodes and edges.
template <class Visit>
void EachProperty(const Site& site, Visit visit) {
  for (const auto& node : site.nodes) {
    const Spot spot{FormatPlace(site, "nodes", node), true};
    for (const auto& properties : node.properties) visit(properties, spot);
  }
  for (const auto& edge : site.edges) {
    const Spot spot{FormatPlace(site, "edges", edge), false};
    for (const auto& properties : edge.properties) visit(properties, spot);
  }
}

const base::JsonValue* FindFirst(const base::JsonValue& value,
                                 std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (const auto* const member = base::FindMember(value, name)) return member;
  }
  return nullptr;
}

class BesideFactsheet {
 public:
  BesideFactsheet(const base::JsonValue& message, Findings& findings)
      : sheet_(vda5050::ReadFactsheet(message)), findings_(findings) {
    if (const auto* const features = base::FindMember(message, "protocolFeatures")) {
      if (const auto* const optional = base::FindArray(*features, "optionalParameters")) {
        has_optional_ = true;
        for (const auto& entry : optional->GetArray()) {
          if (base::StringMember(entry, "support") == "NOT_SUPPORTED") continue;
          optional_.emplace(base::StringMember(entry, "parameter"));
        }
      }
    }
    if (const auto* const load = base::FindMember(message, "loadSpecification")) {
      if (const auto* const sets = base::FindArray(*load, "loadSets")) {
        for (const auto& set : sets->GetArray()) {
          load_sets_.emplace(base::StringMember(set, "setName"));
        }
      }
    }
    if (const auto* const limits = base::FindMember(message, "protocolLimits")) {
      arrays_ = FindFirst(*limits, {"maximumArrayLengths", "maxArrayLens"});
    }
  }

  void CheckId(const std::string& id, const std::string& place) {
    const auto& limits = sheet_.limits;
    if (limits.id_length > 0 && id.size() > limits.id_length) {
      findings_.Warn(place, fmt::format("id '{}' is longer than the {} characters of the factsheet",
                                        Printable(id), limits.id_length));
    }
    if (limits.id_numerical_only && id.find_first_not_of("0123456789") != std::string::npos) {
      findings_.Warn(place,
                     fmt::format("id '{}' is no number, as the factsheet wants", Printable(id)));
    }
  }

  void Check(const layout::NodeProperties& node, const Spot& spot) {
    if (node.theta) CheckOptional("order.nodes.nodePosition.theta", spot);
    CheckCommon(node, spot);
  }

  void Check(const layout::EdgeProperties& edge, const Spot& spot) {
    if (edge.orientation) CheckOptional("order.edges.orientation", spot);
    if (edge.max_speed) CheckOptional("order.edges.maximumSpeed", "order.edges.maxSpeed", spot);
    if (edge.trajectory) {
      CheckOptional("order.edges.trajectory", spot);
      CheckLength("trajectory.knotVector", edge.trajectory->knots.size(), spot);
      CheckLength("trajectory.controlPoints", edge.trajectory->points.size(), spot);
    }
    CheckCommon(edge, spot);
  }

 private:
  void CheckOptional(std::string_view name, const Spot& spot) { CheckOptional(name, name, spot); }
  // Under the name of 3.0 or the older one; what is listed with members below it is there too.
  void CheckOptional(std::string_view name, std::string_view other, const Spot& spot) {
    const auto is_listed = [&](std::string_view wanted) {
      return std::any_of(optional_.begin(), optional_.end(), [&](std::string_view listed) {
        return listed == wanted || wanted.ends_with(std::string(".") + std::string(listed)) ||
               listed.starts_with(std::string(wanted) + ".");
      });
    };
    if (!has_optional_ || is_listed(name) || is_listed(other)) return;
    findings_.Warn(spot.place, fmt::format("needs {}, which the factsheet does not list", name));
  }

  void CheckLength(std::string_view name, std::size_t length, const Spot& spot) {
    const auto* const limit = arrays_ == nullptr ? nullptr : base::FindMember(*arrays_, name);
    if (limit == nullptr || !limit->IsUint() || limit->GetUint() == 0 ||
        length <= limit->GetUint()) {
      return;
    }
    findings_.Warn(spot.place, fmt::format("{} has {} items, and the factsheet allows {}", name,
                                           length, limit->GetUint()));
  }

  template <class Properties>
  void CheckCommon(const Properties& properties, const Spot& spot) {
    CheckLength(spot.is_node ? "node.actions" : "edge.actions", properties.actions.size(), spot);
    for (const auto& action : properties.actions) {
      CheckLength("actions.actionsParameters", action.parameters.size(), spot);
      CheckScope(action, spot);
    }
    for (const std::string& set : properties.load.load_sets) {
      if (load_sets_.empty() || load_sets_.contains(set)) continue;
      findings_.Warn(spot.place,
                     fmt::format("load set {} is none of the factsheet's", Printable(set)));
    }
  }

  void CheckScope(const layout::LayoutAction& action, const Spot& spot) {
    if (sheet_.actions.empty()) return;
    const auto* const listed = vda5050::FindAction(sheet_, action.type);
    const std::string_view scope = spot.is_node ? "NODE" : "EDGE";
    const bool fits = listed != nullptr && (listed->scopes.empty() ||
                                            std::find(listed->scopes.begin(), listed->scopes.end(),
                                                      scope) != listed->scopes.end());
    if (fits) return;
    findings_.Warn(spot.place,
                   fmt::format("action {} is not in the factsheet{}", Printable(action.type),
                               listed == nullptr ? "" : fmt::format(" with scope {}", scope)));
  }

  vda5050::Factsheet sheet_;
  Findings& findings_;
  bool has_optional_ = false;
  std::set<std::string> optional_;
  std::set<std::string, std::less<>> load_sets_;
  const base::JsonValue* arrays_ = nullptr;
};

}  // namespace

void CheckLayoutActions(const Site& site, vda5050::Version version,
                        std::vector<LayoutFinding>& findings) {
  Findings log(findings);
  EachProperty(site, [&](const auto& properties, const Spot& spot) {
    for (const auto& action : properties.actions) CheckAction(action, spot, version, log);
  });
}

void CheckLayoutBeside(const base::JsonValue& factsheet, const Site& site,
                       std::string_view vehicle_type, std::vector<LayoutFinding>& findings) {
  Findings log(findings);
  BesideFactsheet checker(factsheet, log);
  const auto check = [&](const auto& elements, std::string_view array) {
    for (const auto& element : elements) {
      const auto* const properties = element.Find(vehicle_type);
      if (properties == nullptr) continue;
      const Spot spot{FormatPlace(site, array, element), array == "nodes"};
      checker.CheckId(element.id, spot.place);
      checker.Check(*properties, spot);
    }
  };
  check(site.nodes, "nodes");
  check(site.edges, "edges");
}

}  // namespace fleetpub::app
