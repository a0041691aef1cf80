#include "app/order_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <span>
#include <utility>

#include "base/text.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/rules/preflight.h"

namespace fleetpub::app {
namespace {

using base::Printable;
using vda5050::InstantAction;
using vda5050::OrderEdge;
using vda5050::OrderNode;
using vda5050::OrderPosition;

std::string_view ActionType(std::string_view word) {
  return vda5050::ActionCalled(word).value_or(word);
}

std::optional<OrderPosition> ToPosition(const layout::Node& node, std::string_view vehicle_type) {
  const layout::NodeProperties* properties = node.Find(vehicle_type);
  return OrderPosition{.x = node.x,
                       .y = node.y,
                       .theta = properties == nullptr ? std::nullopt : properties->theta,
                       .map_id = node.map_id,
                       .deviation_xy = {},
                       .deviation_theta = {}};
}

std::optional<vda5050::OrderTrajectory> ToTrajectory(
    const std::optional<layout::Trajectory>& trajectory) {
  if (!trajectory) return std::nullopt;
  vda5050::OrderTrajectory curve{
      .degree = trajectory->degree, .knots = trajectory->knots, .points = {}};
  for (const layout::ControlPoint& point : trajectory->points) {
    curve.points.push_back({point.x, point.y, point.weight});
  }
  return curve;
}

double Distance(const OrderPosition& a, double x, double y) { return std::hypot(a.x - x, a.y - y); }

class PathPlanner {
 public:
  PathPlanner(const PathRequest& request, const layout::Site* site, const PathRobot& robot)
      : request_(request), site_(site), robot_(robot) {}

  Result<PlannedPath> Run() {
    Status ok = !request_.stops.empty()    ? AddRoute()
                : !request_.points.empty() ? AddPoints()
                                           : AddWords();
    if (ok) ok = AddWishes();
    if (ok) ok = FitStart();
    if (!ok) return Fail(std::move(ok.error()));
    for (OrderNode& node : path().nodes) {
      if (!node.position) continue;
      if (!node.position->deviation_xy) node.position->deviation_xy = request_.deviation_xy;
      if (!node.position->deviation_theta)
        node.position->deviation_theta = request_.deviation_theta;
    }
    GiveIds();
    planned_.length = MeasureLength();
    return std::move(planned_);
  }

 private:
  [[nodiscard]] vda5050::OrderPath& path() { return planned_.path; }

  void Warn(std::string text) { planned_.warnings.push_back(std::move(text)); }

  [[nodiscard]] std::string Name() const { return Printable(robot_.address.ToString()); }

  Status ChooseType() {
    if (!type_.empty()) return {};
    const std::string suggested =
        robot_.factsheet == nullptr || robot_.factsheet->specification.series.empty()
            ? ""
            : robot_.address.manufacturer + "." + robot_.factsheet->specification.series;
    auto type = layout::ChooseVehicleType(*site_, request_.vehicle_type, suggested);
    if (!type) return Fail(std::move(type.error()));
    type_ = *std::move(type);
    return {};
  }

  [[nodiscard]] bool IsLoaded() const {
    if (request_.loaded || !request_.load_set.empty()) return true;
    return robot_.state != nullptr && robot_.state->loads && !robot_.state->loads->empty();
  }

  // --- A route over the layout

  Status AddRoute() {
    if (site_ == nullptr) {
      return Fail(
          ErrorKind::kUsage,
          "a route needs a layout: --layout FILE, or layout = \"FILE\" in the configuration");
    }
    if (auto ok = ChooseType(); !ok) return ok;
    const std::string& start = request_.from.empty() ? robot_.start : request_.from;
    if (start.empty()) {
      return Fail(ErrorKind::kPreflight,
                  fmt::format("{} does not say at which node it is: --from NODE says it", Name()));
    }
    auto from = layout::ResolvePlace(*site_, start);
    if (!from) {
      if (!request_.from.empty()) return Fail(std::move(from.error()));
      return Fail(
          ErrorKind::kPreflight,
          fmt::format("{} is at node {}, which the layout does not have: --from NODE says another",
                      Name(), Printable(start)));
    }
    layout::RouteRequest route{.vehicle_type = type_,
                               .loaded = IsLoaded(),
                               .load_set = request_.load_set,
                               .cost = request_.cost,
                               .vehicle_speed = {},
                               .from = from->front(),
                               .heading = {},
                               .stops = {}};
    if (robot_.factsheet != nullptr) {
      route.vehicle_speed = robot_.factsheet->specification.maximum_speed;
    }
    const bool is_where_it_is = !robot_.continues && start == robot_.start;
    if (is_where_it_is && robot_.state != nullptr && robot_.state->position) {
      route.heading = robot_.state->position->theta;
    }
    for (const std::string& stop : request_.stops) {
      auto nodes = layout::ResolvePlace(*site_, stop);
      if (!nodes) return Fail(std::move(nodes.error()));
      route.stops.push_back(*std::move(nodes));
    }
    const auto found = layout::FindRoute(*site_, route);
    if (!found) return Fail(found.error());
    for (const std::size_t node : found->nodes) AddNode(site_->nodes[node]);
    for (const layout::RouteEdge& edge : found->edges)
      AddEdge(site_->edges[edge.edge], edge.length, edge.orientation);
    TellMapChanges();
    return {};
  }

  void AddNode(const layout::Node& node) {
    OrderNode out{.id = node.id,
                  .description = node.description,
                  .position = ToPosition(node, type_),
                  .actions = {}};
    if (const layout::NodeProperties* properties = node.Find(type_)) {
      AddRequired(properties->actions, out.actions);
      offered_.push_back(properties->actions);
    } else {
      offered_.emplace_back();
    }
    path().nodes.push_back(std::move(out));
  }

  void AddEdge(const layout::Edge& edge, double length, std::optional<double> orientation) {
    const layout::EdgeProperties& p = *edge.Find(type_);
    const layout::Node& start = site_->nodes[edge.start];
    const layout::Node& end = site_->nodes[edge.end];
    OrderEdge out{.id = edge.id,
                  .description = edge.description,
                  .max_speed = p.max_speed,
                  .max_rotation_speed = p.max_rotation_speed,
                  .max_height = p.max_height,
                  .min_height = p.min_height,
                  .orientation = orientation,
                  .is_tangential = p.is_tangential,
                  .rotation_allowed = p.rotation_allowed,
                  .length = length,
                  .heading = std::atan2(end.y - start.y, end.x - start.x),
                  .trajectory = ToTrajectory(p.trajectory),
                  .actions = {}};
    AddRequired(p.actions, out.actions);
    path().edges.push_back(std::move(out));
  }

  void AddRequired(const std::vector<layout::LayoutAction>& actions,
                   std::vector<InstantAction>& out) const {
    for (const layout::LayoutAction& action : actions) {
      if (action.requirement == layout::Requirement::kRequired) out.push_back(FromLayout(action));
    }
  }

  [[nodiscard]] InstantAction FromLayout(const layout::LayoutAction& action) const {
    InstantAction out{.type = action.type,
                      .id = {},
                      .descriptor = action.description,
                      .blocking_type = action.blocking_type,
                      .parameters = {}};
    for (const layout::ActionParameter& parameter : action.parameters) {
      out.parameters.push_back(
          {parameter.key, parameter.is_json
                              ? parameter.value
                              : vda5050::ToParameterValue(robot_.factsheet, action.type,
                                                          parameter.key, parameter.value)});
    }
    return out;
  }

  void TellMapChanges() {
    const auto& nodes = path().nodes;
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      if (!nodes[i].position || !nodes[i - 1].position) continue;
      const std::string& before = nodes[i - 1].position->map_id;
      const std::string& after = nodes[i].position->map_id;
      if (before == after) continue;
      Warn(
          fmt::format("the way changes from map {} to {} at {}: the robot must be told where it is "
                      "there",
                      Printable(before), Printable(after), Printable(nodes[i].id)));
    }
  }

  // --- Nodes as somebody names them

  Status AddWords() {
    for (const std::string& word : request_.nodes) {
      auto node = FindNode(word);
      if (!node) return Fail(std::move(node.error()));
      if (*node != nullptr) {
        AddNode(**node);
      } else {
        if (site_ != nullptr) {
          Warn(fmt::format("the layout has no node {}: it is sent without a position",
                           Printable(word)));
        }
        path().nodes.push_back({.id = word, .description = {}, .position = {}, .actions = {}});
        offered_.emplace_back();
      }
    }
    return JoinNodes();
  }

  // Null: the layout has none.
  Result<const layout::Node*> FindNode(const std::string& word) {
    if (site_ == nullptr) return nullptr;
    std::optional<std::size_t> node = site_->FindNode(word);
    if (!node) {
      const layout::Station* station = site_->FindStation(word);
      if (station == nullptr) return nullptr;
      if (station->nodes.size() > 1) {
        return Fail(ErrorKind::kUsage,
                    fmt::format("station {} has {} nodes: name one of them, or --to {}",
                                Printable(word), station->nodes.size(), Printable(word)));
      }
      node = station->nodes.front();
    }
    if (auto ok = ChooseType(); !ok) return Fail(std::move(ok.error()));
    return &site_->nodes[*node];
  }

  // The layout's edge where it has one.
  Status JoinNodes() {
    const auto& nodes = path().nodes;
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const layout::Edge* edge = FindEdge(nodes[i - 1].id, nodes[i].id);
      if (edge != nullptr) {
        const layout::EdgeProperties& properties = *edge->Find(type_);
        AddEdge(*edge, layout::EdgeLength(*site_, *edge, properties), properties.orientation);
        continue;
      }
      const bool are_known = nodes[i - 1].position && nodes[i].position;
      if (site_ != nullptr && are_known && request_.points.empty()) {
        Warn(
            fmt::format("the layout has no edge from {} to {} for {}: the robot may refuse it, or "
                        "find a way of its own",
                        Printable(nodes[i - 1].id), Printable(nodes[i].id), Printable(type_)));
      }
      path().edges.push_back({.id = nodes[i - 1].id + "-" + nodes[i].id});
    }
    return {};
  }

  // The shortest of several.
  [[nodiscard]] const layout::Edge* FindEdge(std::string_view from, std::string_view to) const {
    if (site_ == nullptr) return nullptr;
    const auto start = site_->FindNode(from);
    const auto end = site_->FindNode(to);
    if (!start || !end) return nullptr;
    const layout::Edge* best = nullptr;
    double length = 0;
    for (const layout::Edge& edge : site_->edges) {
      if (edge.start != *start || edge.end != *end) continue;
      const layout::EdgeProperties* properties = edge.Find(type_);
      if (properties == nullptr) continue;
      const bool admits = IsLoaded() ? properties->load.loaded : properties->load.unloaded;
      if (!admits) continue;
      const double own = layout::EdgeLength(*site_, edge, *properties);
      if (best != nullptr && own >= length) continue;
      best = &edge;
      length = own;
    }
    return best;
  }

  Status AddPoints() {
    for (const PathPoint& point : request_.points) {
      OrderNode node{
          .id = point.node, .description = {}, .position = point.position, .actions = {}};
      for (const PlacedAction& action : point.actions) node.actions.push_back(FromWish(action));
      path().nodes.push_back(std::move(node));
      offered_.emplace_back();
    }
    return JoinNodes();
  }

  // --- Actions that somebody wants

  [[nodiscard]] InstantAction FromWish(const PlacedAction& wish) const {
    return {.type = wish.type,
            .id = {},
            .descriptor = {},
            .blocking_type = request_.blocking_type.empty() ? "HARD" : request_.blocking_type,
            .parameters = wish.parameters};
  }

  Status AddWishes() {
    for (const PlacedAction& wish : request_.actions) {
      if (const auto node = FindPlace(wish.place)) {
        AddWish(wish, offered_[*node], path().nodes[*node].actions);
        continue;
      }
      auto& edges = path().edges;
      const auto edge = std::find_if(edges.begin(), edges.end(),
                                     [&](const OrderEdge& e) { return e.id == wish.place; });
      if (edge == edges.end()) {
        return Fail(ErrorKind::kUsage, fmt::format("{}@{}: {} is not on the way: {}",
                                                   Printable(wish.type), Printable(wish.place),
                                                   Printable(wish.place), DescribePath(planned_)));
      }
      AddWish(wish, {}, edge->actions);
    }
    return {};
  }

  // The last one, where the way comes by several times: that is where it is going.
  [[nodiscard]] std::optional<std::size_t> FindPlace(std::string_view place) const {
    std::set<std::string_view> ids = {place};
    const layout::Station* station = site_ == nullptr ? nullptr : site_->FindStation(place);
    if (station != nullptr && !site_->FindNode(place)) {
      for (const std::size_t node : station->nodes) ids.insert(site_->nodes[node].id);
    }
    const auto& nodes = planned_.path.nodes;
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (ids.contains(nodes[i].id)) return i;
    }
    return std::nullopt;
  }

  // What the layout says of it holds where nobody says otherwise.
  void AddWish(const PlacedAction& wish, std::span<const layout::LayoutAction> offered,
               std::vector<InstantAction>& actions) const {
    InstantAction* action = nullptr;
    for (InstantAction& there : actions) {
      if (ActionType(there.type) == ActionType(wish.type)) action = &there;
    }
    if (action == nullptr) {
      const auto known = std::find_if(offered.begin(), offered.end(), [&](const auto& candidate) {
        return ActionType(candidate.type) == ActionType(wish.type);
      });
      actions.push_back(known == offered.end() ? FromWish({wish.type, "", {}})
                                               : FromLayout(*known));
      action = &actions.back();
    }
    if (!request_.blocking_type.empty()) action->blocking_type = request_.blocking_type;
    for (const vda5050::Parameter& parameter : wish.parameters) {
      const auto same =
          std::find_if(action->parameters.begin(), action->parameters.end(),
                       [&](const vda5050::Parameter& p) { return p.key == parameter.key; });
      if (same == action->parameters.end()) {
        action->parameters.push_back(parameter);
      } else {
        *same = parameter;
      }
    }
  }

  void GiveIds() {
    const auto give = [&](std::vector<InstantAction>& actions) {
      for (InstantAction& action : actions) action.id = vda5050::MakeActionId(robot_.factsheet);
    };
    for (OrderNode& node : path().nodes) give(node.actions);
    for (OrderEdge& edge : path().edges) give(edge.actions);
  }

  // --- Where the robot is

  // A robot refuses an order whose first node is elsewhere. Where it is a little off that node, or on
  // its way to the next, the node is told to be wide enough (3.0 §6.1.3.1; 2.1 §6.6.4).
  Status FitStart() {
    OrderNode& first = path().nodes.front();
    if (robot_.continues) return {};
    if (!robot_.start.empty() && robot_.start != first.id && request_.from.empty()) {
      return Fail(
          ErrorKind::kPreflight,
          fmt::format("{} is at node {}, and the order begins at {}: name {} first", Name(),
                      Printable(robot_.start), Printable(first.id), Printable(robot_.start)));
    }
    if (robot_.state == nullptr || !robot_.state->position || !first.position) return {};
    const vda5050::RobotPosition& now = *robot_.state->position;
    if (!now.x || !now.y || now.map_id != first.position->map_id) return {};
    constexpr double kOnIt = 0.005;
    constexpr double kMargin = 0.01;
    const double off = Distance(*first.position, *now.x, *now.y);
    if (first.position->theta) first.position->deviation_theta = std::numbers::pi;
    if (off <= std::max(kOnIt, request_.deviation_xy.value_or(0))) return {};
    if (off > MostOff()) {
      if (!robot_.is_checked) return {};
      return Fail(ErrorKind::kPreflight, DescribeLost(off));
    }
    constexpr double kMillimetres = 1000;
    first.position->deviation_xy = std::ceil((off + kMargin) * kMillimetres) / kMillimetres;
    if (off >= 1) {
      Warn(fmt::format("{} is {:.1f} m from {}, where the order begins", Name(), off,
                       Printable(first.id)));
    }
    return {};
  }

  // An order of the first node alone has nothing left to do on a robot that it is made wide for.
  [[nodiscard]] double MostOff() const {
    constexpr double kALittle = 0.3;
    constexpr double kBesideTheWay = 1;
    const auto& [nodes, edges] = planned_.path;
    if (edges.empty()) return kALittle;
    const auto& next = nodes[1].position;
    if (!next) return std::numeric_limits<double>::infinity();
    return kBesideTheWay + std::max(Distance(*nodes[0].position, next->x, next->y),
                                    edges.front().length.value_or(0));
  }

  [[nodiscard]] std::string DescribeLost(double off) const {
    const auto& nodes = planned_.path.nodes;
    const std::string first = Printable(nodes.front().id);
    if (nodes.size() == 1) {
      return fmt::format(
          "{0} is {1:.1f} m from {2}, which an order of {2} alone would take for "
          "there: it would be done before it moved. try: fleetpub show {0}",
          Name(), off, first);
    }
    return fmt::format(
        "{0} is {1:.1f} m from {2}, where the order begins, and not on the way from "
        "there to {3}. try: fleetpub show {0}",
        Name(), off, first, Printable(nodes[1].id));
  }

  [[nodiscard]] std::optional<double> MeasureLength() const {
    double length = 0;
    const auto& [nodes, edges] = planned_.path;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if (edges[i].length) {
        length += *edges[i].length;
      } else if (nodes[i].position && nodes[i + 1].position) {
        length += Distance(*nodes[i].position, nodes[i + 1].position->x, nodes[i + 1].position->y);
      } else {
        return std::nullopt;
      }
    }
    return length;
  }

  const PathRequest& request_;
  const layout::Site* site_;
  const PathRobot& robot_;
  std::string type_;
  PlannedPath planned_;
  std::vector<std::span<const layout::LayoutAction>> offered_;  // at each node
};

}  // namespace

Result<PlannedPath> PlanPath(const PathRequest& request, const layout::Site* site,
                             const PathRobot& robot) {
  return PathPlanner(request, site, robot).Run();
}

std::string DescribePath(const PlannedPath& planned) {
  constexpr std::size_t kShown = 10;
  const auto& nodes = planned.path.nodes;
  std::vector<std::string> names;
  std::size_t actions = 0;
  for (const OrderNode& node : nodes) {
    names.push_back(Printable(node.id));
    actions += node.actions.size();
  }
  for (const OrderEdge& edge : planned.path.edges) actions += edge.actions.size();
  if (names.size() > kShown) {
    names.erase(names.begin() + 3, names.end() - 3);
    names.insert(names.begin() + 3, fmt::format("{} more", nodes.size() - 6));
  }
  std::string text = base::Join(names, " → ");
  if (planned.length) text += fmt::format(", {:.1f} m", *planned.length);
  if (actions > 0) text += ", " + base::Counted(actions, "action");
  return text;
}

}  // namespace fleetpub::app
