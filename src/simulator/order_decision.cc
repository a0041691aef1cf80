#include "simulator/order_decision.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::simulator {
namespace {

using vda5050::kAllVersions;
using vda5050::kFrom21;
using vda5050::kFrom30;
using vda5050::kUpTo21;
using vda5050::Version;
using vda5050::VersionRange;

// ---- How each refusal is reported ----

enum class Refusal {
  kMalformed,
  kUnsupported,
  kUnknownAction,
  kOutdated,
  kOtherContent,
  kOtherOrderActive,
  kNewAboveZero,
  kStartOutOfRange,
  kNoRoute,
  kUnknownMap,
  kMode,
  kMemory,
  kAfterCancel,
  kCancelling,
  kWrongStitch,
  kWrongContinuation,
  kOtherZoneSet,
};

struct RefusalFacts {
  Refusal refusal;
  std::string_view up_to_20;  ///< errorType
  std::string_view in_21;
  std::string_view from_30;
  std::string_view level_30;  ///< up to 2.1 it is WARNING
  bool names_update_30;       ///< orderUpdateId beside orderId, as up to 2.1
  Until until;
};

// Where a text demands a refusal and names no type, it is the nearest one that it has.
constexpr auto kRefusals = std::to_array<RefusalFacts>({
    {Refusal::kMalformed, "validationError", "validationError", "VALIDATION_FAILURE", "WARNING",
     true, Until::kNextOrder},
    {Refusal::kUnsupported, "orderError", "orderError", "UNSUPPORTED_PARAMETER", "CRITICAL", false,
     Until::kNextOrder},
    {Refusal::kUnknownAction, "orderError", "orderError", "INVALID_ORDER_ACTION", "WARNING", true,
     Until::kNextOrder},
    {Refusal::kOutdated, "orderUpdateError", "orderUpdateError", "OUTDATED_ORDER_UPDATE", "WARNING",
     true, Until::kNextOrder},
    {Refusal::kOtherContent, "", "", "SAME_ORDER_UPDATE_ID", "WARNING", true, Until::kNextOrder},
    {Refusal::kOtherOrderActive, "orderUpdateError", "orderUpdateError", "OTHER_ORDER_ACTIVE",
     "WARNING", false, Until::kNextOrder},
    {Refusal::kNewAboveZero, "", "", "VALIDATION_FAILURE", "WARNING", true, Until::kNextOrder},
    {Refusal::kStartOutOfRange, "noRouteError", "noRouteError", "START_NODE_OUT_OF_RANGE",
     "WARNING", false, Until::kNextOrder},
    {Refusal::kNoRoute, "noRouteError", "noRouteError", "NO_ROUTE_TO_TARGET", "WARNING", false,
     Until::kNextOrder},
    {Refusal::kUnknownMap, "", "orderError", "UNKNOWN_MAP_ID", "WARNING", false, Until::kNextOrder},
    {Refusal::kMode, "orderError", "orderError", "MOBILE_ROBOT_NOT_AVAILABLE", "WARNING", false,
     Until::kNextMode},
    {Refusal::kMemory, "orderError", "orderError", "INSUFFICIENT_MEMORY", "URGENT", false,
     Until::kNextOrder},
    {Refusal::kAfterCancel, "", "", "ORDER_UPDATE_FOLLOWING_CANCEL", "WARNING", true,
     Until::kNextOrder},
    {Refusal::kCancelling, "orderError", "orderError", "ORDER_UPDATE_FOLLOWING_CANCEL", "WARNING",
     true, Until::kNextOrder},
    {Refusal::kWrongStitch, "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE", "WARNING",
     true, Until::kNextOrder},
    {Refusal::kWrongContinuation, "orderUpdateError", "orderUpdateError", "VALIDATION_FAILURE",
     "WARNING", true, Until::kNextOrder},
    {Refusal::kOtherZoneSet, "orderError", "orderError", "", "WARNING", true, Until::kNextOrder},
});

RobotError MakeError(Refusal refusal, const Inspection& inspection, const Settings& settings,
                     std::string description, References further = {}) {
  const RefusalFacts& facts = kRefusals.at(static_cast<std::size_t>(refusal));
  const bool is_30 = settings.version >= Version::k300;
  RobotError error{.type = std::string(is_30                               ? facts.from_30
                                       : settings.version == Version::k210 ? facts.in_21
                                                                           : facts.up_to_20),
                   .description = std::move(description),
                   .references = {{"topic", "order"}},
                   .until = facts.until,
                   .level = is_30 ? facts.level_30 : "WARNING"};
  if (settings.Has(Fault::kOrderErrorForAll)) error.type = "orderError";
  if (!inspection.header_id.empty()) {
    error.references.emplace_back("headerId", inspection.header_id);
  }
  const std::string_view order = base::StringMember(inspection.message, "orderId");
  if (!order.empty()) error.references.emplace_back("orderId", order);
  const auto* update = base::FindMember(inspection.message, "orderUpdateId");
  if ((facts.names_update_30 || !is_30) && update != nullptr && update->IsUint64()) {
    error.references.emplace_back("orderUpdateId", fmt::format("{}", update->GetUint64()));
  }
  for (auto& reference : further) error.references.push_back(std::move(reference));
  return error;
}

// ---- The questions ----

struct Objection {
  std::string why;
  References references = {};
};
using Answer = std::optional<Objection>;  // none: no

bool IsOfActiveOrder(const Asked& a) {
  return !a.state.order.id.empty() && a.plan.order.id == a.state.order.id;
}

const NodeLeg& First(const Asked& a) { return a.plan.order.nodes.front(); }

// Up to 2.1 the text counts every action that it lists, instant ones too (2.1 §6.6.2).
bool IsIdle(const Asked& a) {
  const bool counts_instant = a.settings.version < Version::k300;
  const auto is_open = [](const ActionState& action) { return !IsEnded(action.status); };
  return !a.state.HasWork() &&
         !(counts_instant &&
           std::any_of(a.state.instant_actions.begin(), a.state.instant_actions.end(), is_open));
}

bool BeginsAt(const Asked& a, std::string_view id, std::uint32_t sequence_id) {
  return First(a).id == id && First(a).sequence_id == sequence_id;
}

bool BeginsAtDecisionPoint(const Asked& a) {
  const Leg& end = a.state.order.decision_point;
  return BeginsAt(a, end.id, end.sequence_id);
}

Answer IsBusyButContinued(const Asked& a) {
  if (!a.state.order.Active() || !BeginsAtDecisionPoint(a)) return std::nullopt;
  return Objection{};
}

Answer IsBusy(const Asked& a) {
  if (IsIdle(a) || a.settings.Has(Fault::kTakeWhileBusy)) return std::nullopt;
  return Objection{a.state.HasWork()
                       ? fmt::format("order {} is still active", base::Printable(a.state.order.id))
                       : "an instant action is still running"};
}

Answer IsAboveZero(const Asked& a) {
  if (a.plan.order.update_id == 0 || a.settings.Has(Fault::kTakeAnyUpdateId)) return std::nullopt;
  return Objection{
      fmt::format("a new order begins with orderUpdateId 0, not {}", a.plan.order.update_id)};
}

constexpr double kTolerance = 0.1;  // m and rad: how exactly it stands

bool IsWithin(const Place& place, const Position& position) {
  const double dx = position.x - place.x;
  const double dy = position.y - place.y;
  const double along = dx * std::cos(place.deviation_angle) + dy * std::sin(place.deviation_angle);
  const double across = dy * std::cos(place.deviation_angle) - dx * std::sin(place.deviation_angle);
  const double a = along / (place.deviation_a + kTolerance);
  const double b = across / (place.deviation_b + kTolerance);
  if (a * a + b * b > 1) return false;
  if (!place.theta) return true;
  const double turn = std::remainder(position.theta - *place.theta, 2 * std::numbers::pi);
  return std::abs(turn) <= place.deviation_theta + kTolerance;
}

// The place that its states tell counts; where nobody told it where it is, the node's name will do, too.
Answer StartsElsewhere(const Asked& a) {
  if (a.settings.Has(Fault::kTakeAnyStart)) return std::nullopt;
  const NodeLeg& first = First(a);
  const Position& here = a.state.position;
  const References node = {{"nodeId", first.id}};
  if (first.place) {
    Place allowed = *first.place;
    if (a.settings.Has(Fault::kExactStart)) allowed.deviation_a = allowed.deviation_b = 0;
    if (allowed.map_id == here.map_id && IsWithin(allowed, here)) return std::nullopt;
    if (a.state.is_placed) {
      return Objection{
          fmt::format("node {} at {:.2f}, {:.2f} on {} is out of reach: the robot is at {:.2f}, "
                      "{:.2f}, heading {:.2f}, on {}",
                      base::Printable(first.id), first.place->x, first.place->y,
                      base::Printable(first.place->map_id), here.x, here.y, here.theta,
                      base::Printable(here.map_id)),
          node};
    }
  }
  if (a.state.last_node_id.empty() || a.state.last_node_id == first.id) return std::nullopt;
  return Objection{fmt::format("node {} is out of reach: the robot is at {}",
                               base::Printable(first.id), base::Printable(a.state.last_node_id)),
                   node};
}

Answer IsOneNode(const Asked& a) {
  if (!a.settings.Has(Fault::kNoEmptyOrder) || a.plan.order.nodes.size() > 1) return std::nullopt;
  return Objection{"an order has two nodes or more"};
}

Answer IsOutdated(const Asked& a) {
  const bool is_lower = a.plan.order.update_id < a.state.order.update_id;
  if (!is_lower || a.settings.Has(Fault::kTakeAnyUpdateId)) return std::nullopt;
  return Objection{fmt::format("orderUpdateId {} is not above {}", a.plan.order.update_id,
                               a.state.order.update_id)};
}

Answer IsCancelled(const Asked& a) {
  if (!a.state.order.is_cancelled || a.settings.Has(Fault::kTakeAfterCancel)) return std::nullopt;
  return Objection{fmt::format("order {} was cancelled", base::Printable(a.state.order.id))};
}

Answer IsSameUpdate(const Asked& a) {
  if (a.plan.order.update_id != a.state.order.update_id) return std::nullopt;
  return Objection{};
}

Answer IsResent(const Asked& a) {
  if (!a.is_same_content || a.settings.Has(Fault::kRefuseResend)) return std::nullopt;
  return IsSameUpdate(a);
}

Answer IsRefusedResend(const Asked& a) {
  if (!a.settings.Has(Fault::kRefuseResend) || !IsSameUpdate(a)) return std::nullopt;
  return Objection{fmt::format("orderUpdateId {} is there already", a.plan.order.update_id)};
}

Answer IsOtherContent(const Asked& a) {
  if (!IsSameUpdate(a)) return std::nullopt;
  return Objection{fmt::format("orderUpdateId {} is not above {}: it had another content",
                               a.plan.order.update_id, a.state.order.update_id)};
}

Answer IsBeingCancelled(const Asked& a) {
  if (!a.is_cancelling) return std::nullopt;
  return Objection{fmt::format("order {} is being cancelled", base::Printable(a.state.order.id))};
}

Answer StitchesElsewhere(const Asked& a) {
  if (a.settings.Has(Fault::kTakeAnyStitch)) return std::nullopt;
  if (!a.state.HasWork() || BeginsAtDecisionPoint(a)) return std::nullopt;
  const Leg& end = a.state.order.decision_point;
  return Objection{fmt::format("the base ends at node {} with sequenceId {}, the update begins at "
                               "{} with {}",
                               base::Printable(end.id), end.sequence_id,
                               base::Printable(First(a).id), First(a).sequence_id),
                   {{"nodeId", First(a).id}}};
}

Answer ContinuesElsewhere(const Asked& a) {
  if (a.settings.Has(Fault::kTakeAnyStitch)) return std::nullopt;
  const RobotState& state = a.state;
  if (state.HasWork() || BeginsAt(a, state.last_node_id, state.last_node_sequence_id)) {
    return std::nullopt;
  }
  return Objection{fmt::format("the robot is at node {} with sequenceId {}, the update begins at "
                               "{} with {}",
                               base::Printable(state.last_node_id), state.last_node_sequence_id,
                               base::Printable(First(a).id), First(a).sequence_id),
                   {{"nodeId", First(a).id}}};
}

// ---- Those that have no place in the figure ----

Answer IsInOtherMode(const Asked& a) {
  const std::string& mode = a.state.operating_mode;
  // INTERVENED: it will be driven afterwards (3.0 §6.6.7).
  if (a.state.IsAutomatic() || mode == "INTERVENED") return std::nullopt;
  if (a.settings.Has(Fault::kTakeInAnyMode)) return std::nullopt;
  return Objection{fmt::format("no orders in operating mode {}", mode)};
}

Answer IsTooLarge(const Asked& a) {
  const std::size_t limit = a.settings.order_limit;
  const std::size_t size = a.plan.order.nodes.size();
  if (limit == 0 || size <= limit) return std::nullopt;
  return Objection{fmt::format("{} nodes are too many: it has room for {}", size, limit)};
}

Answer HasOtherZoneSet(const Asked& a) {
  const std::string& used = a.state.order.zone_set_id;
  const std::string& asked = a.plan.order.zone_set_id;
  if (!IsOfActiveOrder(a) || asked == used) return std::nullopt;
  return Objection{
      fmt::format("zone set {} is in use, not {}", base::Printable(used), base::Printable(asked)),
      {{"zoneSetId", asked}}};
}

Answer HasUnsupportedMember(const Asked& a) {
  if (a.settings.Has(Fault::kTakeUnsupported)) return std::nullopt;
  const auto members = FindUnsupported(a.inspection.message, a.settings.version);
  if (members.empty()) return std::nullopt;
  const std::vector<std::string> names(members.begin(), members.end());
  Objection objection{fmt::format("it cannot use {}", base::Join(names, ", "))};
  for (const auto member : members) objection.references.emplace_back("parameter", member);
  return objection;
}

Answer HasUnknownAction(const Asked& a) {
  if (a.settings.Has(Fault::kTakeUnknownActions)) return std::nullopt;
  const auto refer = [](std::string why, std::string_view id, std::string_view type) {
    return Objection{std::move(why),
                     {{"actionId", std::string(id)}, {"actionType", std::string(type)}}};
  };
  for (const ReceivedAction& action : a.inspection.actions) {
    if (!action.fault.empty()) return refer(action.fault, action.call.id, action.call.type);
    if (a.settings.reject.contains(action.call.type)) {
      return refer(fmt::format("{} is rejected, as asked for", action.call.type), action.call.id,
                   action.call.type);
    }
  }
  if (!IsOfActiveOrder(a)) return std::nullopt;
  // Those of the base stay until there is a new order.
  const std::uint32_t base_end = First(a).sequence_id;
  for (const OrderAction& action : a.plan.actions) {
    const bool is_known =
        action.sequence_id > base_end &&
        std::any_of(a.state.order_actions.begin(), a.state.order_actions.end(),
                    [&](const OrderAction& known) {
                      return known.id == action.id && known.sequence_id <= base_end;
                    });
    if (is_known) return refer("this actionId has been used in the order", action.id, action.type);
  }
  return std::nullopt;
}

Answer HasUnknownMap(const Asked& a) {
  if (a.settings.Has(Fault::kTakeUnknownMaps)) return std::nullopt;
  for (const NodeLeg& node : a.plan.order.nodes) {
    if (!node.place) continue;
    const bool is_there = std::any_of(a.state.maps.begin(), a.state.maps.end(),
                                      [&](const Map& map) { return map.id == node.place->map_id; });
    if (is_there) continue;
    return Objection{fmt::format("there is no map {}", base::Printable(node.place->map_id)),
                     {{"nodeId", node.id}, {"mapId", node.place->map_id}}};
  }
  return std::nullopt;
}

// A node that it was told so of, and an edge that nobody may move on.
Answer HasNoRoute(const Asked& a) {
  for (const NodeLeg& node : a.plan.order.nodes) {
    if (!a.settings.unreachable.contains(node.id)) continue;
    return Objection{fmt::format("no way leads to node {}", base::Printable(node.id)),
                     {{"nodeId", node.id}}};
  }
  for (const EdgeLeg& edge : a.plan.order.edges) {
    if (!edge.max_speed || *edge.max_speed > 0) continue;
    return Objection{fmt::format("edge {} allows no speed", base::Printable(edge.id)),
                     {{"edgeId", edge.id}}};
  }
  return std::nullopt;
}

enum class Of { kNew, kUpdate, kEvery };

struct Question {
  Of of;
  VersionRange versions;
  Answer (*ask)(const Asked& asked);
  Outcome outcome;  ///< when the answer is yes
  Refusal refusal = Refusal::kMalformed;
};

constexpr VersionRange kOnly11 = {Version::k110, Version::k110};

using enum Outcome;

// In the order of the figure; the first yes decides.
constexpr auto kQuestions = std::to_array<Question>({
    {Of::kNew, kOnly11, IsBusyButContinued, kReplace},
    {Of::kNew, kAllVersions, IsBusy, kRefuse, Refusal::kOtherOrderActive},
    {Of::kNew, kFrom30, IsAboveZero, kRefuse, Refusal::kNewAboveZero},
    {Of::kNew, kAllVersions, StartsElsewhere, kRefuse, Refusal::kStartOutOfRange},
    {Of::kUpdate, kAllVersions, IsOutdated, kRefuse, Refusal::kOutdated},
    {Of::kUpdate, kFrom30, IsCancelled, kRefuse, Refusal::kAfterCancel},
    {Of::kUpdate, kAllVersions, IsResent, kDiscard},
    {Of::kUpdate, kFrom30, IsOtherContent, kRefuse, Refusal::kOtherContent},
    {Of::kUpdate, kUpTo21, IsRefusedResend, kRefuse, Refusal::kOutdated},
    {Of::kUpdate, kUpTo21, IsSameUpdate, kDiscard},
    {Of::kUpdate, kAllVersions, IsBeingCancelled, kRefuse, Refusal::kCancelling},
    {Of::kUpdate, kAllVersions, StitchesElsewhere, kRefuse, Refusal::kWrongStitch},
    {Of::kUpdate, kAllVersions, ContinuesElsewhere, kRefuse, Refusal::kWrongContinuation},
    // What the figure does not ask: only of what would be taken otherwise.
    {Of::kEvery, kAllVersions, IsOneNode, kRefuse, Refusal::kMalformed},
    {Of::kEvery, kAllVersions, IsInOtherMode, kRefuse, Refusal::kMode},
    {Of::kEvery, kAllVersions, IsTooLarge, kRefuse, Refusal::kMemory},
    {Of::kEvery, kUpTo21, HasOtherZoneSet, kRefuse, Refusal::kOtherZoneSet},
    {Of::kEvery, kAllVersions, HasUnsupportedMember, kRefuse, Refusal::kUnsupported},
    {Of::kEvery, kAllVersions, HasUnknownAction, kRefuse, Refusal::kUnknownAction},
    {Of::kEvery, kFrom21, HasUnknownMap, kRefuse, Refusal::kUnknownMap},
    {Of::kEvery, kAllVersions, HasNoRoute, kRefuse, Refusal::kNoRoute},
});

// Once an update under another orderId has been decided on, the rest asks about both alike.
constexpr Outcome Otherwise(bool is_update) { return is_update ? kUpdate : kNew; }

}  // namespace

Decision Decide(const Asked& asked) {
  const bool is_update = IsOfActiveOrder(asked);
  Outcome accepted = Otherwise(is_update);
  for (const Question& question : kQuestions) {
    if (!question.versions.Contains(asked.settings.version)) continue;
    const bool is_of_this = question.of == Of::kEvery ||
                            (accepted != kReplace && (question.of == Of::kUpdate) == is_update);
    if (!is_of_this) continue;
    Answer answer = question.ask(asked);
    if (!answer) continue;
    if (question.outcome == kReplace) {
      accepted = kReplace;
      continue;
    }
    if (question.outcome == kDiscard) return {kDiscard};
    return {kRefuse, MakeError(question.refusal, asked.inspection, asked.settings,
                               std::move(answer->why), std::move(answer->references))};
  }
  return {accepted};
}

RobotError RefuseMalformed(const Inspection& inspection, const Settings& settings) {
  return MakeError(Refusal::kMalformed, inspection, settings, inspection.fault);
}

}  // namespace fleetpub::simulator
