#include "simulator/action_handlers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace fleetpub::simulator {
namespace {

ActionResult Failed(std::string result) { return {.finished = false, .result = std::move(result)}; }

ActionResult Failed(std::string result, std::string_view error_type,
                    std::vector<std::pair<std::string, std::string>> references, Until until) {
  RobotError error{std::string(error_type), result, std::move(references), until};
  return {.finished = false, .result = std::move(result), .error = std::move(error)};
}

bool IsRetriable(const RobotState& state, std::string_view id) {
  const auto is_it = [&](const ActionState& action) {
    return action.id == id && action.status == ActionStatus::kRetriable;
  };
  return std::any_of(state.order_actions.begin(), state.order_actions.end(), is_it) ||
         std::any_of(state.instant_actions.begin(), state.instant_actions.end(), is_it);
}

ActionResult StartPause(const ActionCall& /*call*/, RobotState& state,
                        const ProtocolTerms& /*terms*/) {
  state.paused = true;
  return {};
}

ActionResult StopPause(const ActionCall& /*call*/, RobotState& state,
                       const ProtocolTerms& /*terms*/) {
  state.paused = false;
  return {};
}

ActionResult StartCharging(const ActionCall& /*call*/, RobotState& state,
                           const ProtocolTerms& /*terms*/) {
  if (state.driving) return Failed("cannot charge while driving");
  state.charging = true;
  return {};
}

ActionResult StopCharging(const ActionCall& /*call*/, RobotState& state,
                          const ProtocolTerms& /*terms*/) {
  state.charging = false;
  return {};
}

// Of the versions of one map, this one and no other.
void Enable(std::vector<Map>& maps, std::string_view id, std::string_view version) {
  for (Map& map : maps) {
    if (map.id == id) map.enabled = map.version == version;
  }
}

ActionResult InitializePosition(const ActionCall& call, RobotState& state,
                                const ProtocolTerms& /*terms*/) {
  state.position = {call.Number("x"), call.Number("y"), call.Number("theta"), call.Text("mapId")};
  state.is_placed = true;
  state.last_node_id = call.Text("lastNodeId");
  const auto known = std::find_if(state.maps.rbegin(), state.maps.rend(),
                                  [&](const Map& map) { return map.id == state.position.map_id; });
  if (known != state.maps.rend()) Enable(state.maps, known->id, std::string(known->version));
  return {};
}

auto FindMap(RobotState& state, const ActionCall& call) {
  return std::find_if(state.maps.begin(), state.maps.end(), [&](const Map& map) {
    return map.id == call.Text("mapId") && map.version == call.Text("mapVersion");
  });
}

std::string NameOfMap(const ActionCall& call) {
  return fmt::format("map {} version {}", call.Text("mapId"), call.Text("mapVersion"));
}

ActionResult DownloadMap(const ActionCall& call, RobotState& state, const ProtocolTerms& terms) {
  if (FindMap(state, call) != state.maps.end()) {
    return Failed(NameOfMap(call) + " is already there", terms.duplicate_map,
                  {{"actionId", call.id},
                   {"mapId", call.Text("mapId")},
                   {"mapVersion", call.Text("mapVersion")}},
                  Until::kNextInstantAction);
  }
  state.maps.push_back({call.Text("mapId"), call.Text("mapVersion"), false});
  return {};
}

ActionResult EnableMap(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  if (FindMap(state, call) == state.maps.end()) return Failed(NameOfMap(call) + " is not there");
  Enable(state.maps, call.Text("mapId"), call.Text("mapVersion"));
  return {};
}

ActionResult DeleteMap(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  const auto map = FindMap(state, call);
  if (map == state.maps.end()) return Failed(NameOfMap(call) + " is not there");
  if (map->enabled) return Failed(NameOfMap(call) + " is in use");
  state.maps.erase(map);
  return {};
}

auto FindZoneSet(RobotState& state, const ActionCall& call) {
  return std::find_if(state.zone_sets.begin(), state.zone_sets.end(),
                      [&](const ZoneSet& set) { return set.id == call.Text("zoneSetId"); });
}

std::string NameOfZoneSet(const ActionCall& call) { return "zone set " + call.Text("zoneSetId"); }

ActionResult DownloadZoneSet(const ActionCall& call, RobotState& state,
                             const ProtocolTerms& terms) {
  if (FindZoneSet(state, call) != state.zone_sets.end()) {
    return Failed(NameOfZoneSet(call) + " is already there", terms.duplicate_zone_set,
                  {{"actionId", call.id}, {"zoneSetId", call.Text("zoneSetId")}},
                  Until::kNextInstantAction);
  }
  state.zone_sets.push_back({call.Text("zoneSetId"), state.position.map_id, false});
  return {};
}

ActionResult EnableZoneSet(const ActionCall& call, RobotState& state,
                           const ProtocolTerms& /*terms*/) {
  const auto chosen = FindZoneSet(state, call);
  if (chosen == state.zone_sets.end()) return Failed(NameOfZoneSet(call) + " is not there");
  for (ZoneSet& set : state.zone_sets) {
    if (set.map_id == chosen->map_id) set.enabled = set.id == chosen->id;
  }
  return {};
}

ActionResult DeleteZoneSet(const ActionCall& call, RobotState& state,
                           const ProtocolTerms& /*terms*/) {
  const auto set = FindZoneSet(state, call);
  if (set == state.zone_sets.end()) return Failed(NameOfZoneSet(call) + " is not there");
  if (set->enabled) return Failed(NameOfZoneSet(call) + " is in use");
  state.zone_sets.erase(set);
  return {};
}

// Its own entry stays: it is not ended yet.
ActionResult ClearInstantActions(const ActionCall& call, RobotState& state,
                                 const ProtocolTerms& /*terms*/) {
  std::erase_if(state.instant_actions, [&](const ActionState& action) {
    return IsEnded(action.status) && action.id != call.id;
  });
  return {};
}

ActionResult LogReport(const ActionCall& call, RobotState& /*state*/,
                       const ProtocolTerms& /*terms*/) {
  return {.result = fmt::format("log-{}.txt", call.id)};
}

ActionResult Trigger(const ActionCall& /*call*/, RobotState& state,
                     const ProtocolTerms& /*terms*/) {
  int released = 0;
  for (ActionState& action : state.order_actions) {
    if (action.type != "waitForTrigger" || action.status != ActionStatus::kRunning) continue;
    action.status = ActionStatus::kFinished;
    ++released;
  }
  return released > 0 ? ActionResult{} : Failed("nothing waits for a trigger");
}

ActionResult OnRetriable(const ActionCall& call, RobotState& state, SideEffect side_effect) {
  const std::string target = call.Text("actionId");
  if (!IsRetriable(state, target)) {
    return Failed(fmt::format("no action {} is RETRIABLE", target));
  }
  return {.side_effect = side_effect, .target = target};
}

ActionResult Retry(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  return OnRetriable(call, state, SideEffect::kRetry);
}

ActionResult SkipRetry(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  return OnRetriable(call, state, SideEffect::kSkipRetry);
}

ActionResult CancelOrder(const ActionCall& call, RobotState& state, const ProtocolTerms& terms) {
  const std::string wanted = call.Text("orderId");
  const bool other = !wanted.empty() && wanted != state.order.id;
  if (!state.HasWork() || other) {
    return Failed(other ? fmt::format("order {} is not active", wanted) : "no order is active",
                  terms.no_order, {{"actionId", call.id}}, Until::kNextOrder);
  }
  return {.side_effect = SideEffect::kCancel};
}

ActionResult Pick(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  state.loads.push_back({call.Text("loadId"), call.Text("loadType")});
  return {};
}

// The load that is named, or the last one.
ActionResult Drop(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  const std::string id = call.Text("loadId");
  const auto load = std::find_if(state.loads.rbegin(), state.loads.rend(),
                                 [&](const Load& one) { return id.empty() || one.id == id; });
  if (load == state.loads.rend()) return Failed("there is no such load on board");
  state.loads.erase(std::next(load).base());
  return {};
}

ActionResult FactsheetRequest(const ActionCall& /*call*/, RobotState& /*state*/,
                              const ProtocolTerms& /*terms*/) {
  return {.side_effect = SideEffect::kFactsheet};
}

ActionResult StartHibernation(const ActionCall& /*call*/, RobotState& state,
                              const ProtocolTerms& /*terms*/) {
  GiveUpOrder(state);
  return {.side_effect = SideEffect::kHibernate};
}

ActionResult StopHibernation(const ActionCall& /*call*/, RobotState& /*state*/,
                             const ProtocolTerms& /*terms*/) {
  return {.side_effect = SideEffect::kWake};
}

ActionResult Shutdown(const ActionCall& call, RobotState& state, const ProtocolTerms& /*terms*/) {
  const bool busy = std::any_of(
      state.instant_actions.begin(), state.instant_actions.end(),
      [&](const ActionState& action) { return !IsEnded(action.status) && action.id != call.id; });
  if (busy || state.HasWork()) return Failed("the robot is not idle");
  return {.side_effect = SideEffect::kShutDown};
}

using enum Beginning;

struct Effect {
  std::string_view type;
  Beginning beginning;
  ActionResult (*execute)(const ActionCall& call, RobotState& state, const ProtocolTerms& terms);
};

// stateRequest, clearZoneActions (there are none) and updateCertificate change nothing here.
constexpr auto kEffects = std::to_array<Effect>({
    {"startPause", kRunning, StartPause},
    {"stopPause", kRunning, StopPause},
    {"startHibernation", kRunning, StartHibernation},
    {"stopHibernation", kRunning, StopHibernation},
    {"shutdown", kRunning, Shutdown},
    {"startCharging", kRunning, StartCharging},
    {"stopCharging", kRunning, StopCharging},
    {"initPosition", kInitializing, InitializePosition},
    {"initializePosition", kInitializing, InitializePosition},
    {"enableMap", kInitializing, EnableMap},
    {"downloadMap", kInitializing, DownloadMap},
    {"deleteMap", kInitializing, DeleteMap},
    {"downloadZoneSet", kInitializing, DownloadZoneSet},
    {"enableZoneSet", kInitializing, EnableZoneSet},
    {"deleteZoneSet", kInitializing, DeleteZoneSet},
    {"clearInstantActions", kWaiting, ClearInstantActions},
    {"logReport", kInitializing, LogReport},
    {"trigger", kWaiting, Trigger},
    {"retry", kWaiting, Retry},
    {"skipRetry", kWaiting, SkipRetry},
    {"cancelOrder", kRunning, CancelOrder},
    {"stateRequest", kWaiting, nullptr},
    {"factsheetRequest", kWaiting, FactsheetRequest},
    {"pick", kRunning, Pick},
    {"drop", kRunning, Drop},
});

const Effect* FindEffect(std::string_view type) {
  const auto* const found = std::find_if(kEffects.begin(), kEffects.end(),
                                         [&](const Effect& effect) { return effect.type == type; });
  return found == kEffects.end() ? nullptr : found;
}

}  // namespace

std::string ActionCall::Text(std::string_view key) const {
  for (const Parameter& parameter : parameters) {
    const auto* text = std::get_if<std::string>(&parameter.value);
    if (parameter.key == key && text != nullptr) return *text;
  }
  return {};
}

double ActionCall::Number(std::string_view key) const {
  for (const Parameter& parameter : parameters) {
    const auto* number = std::get_if<double>(&parameter.value);
    if (parameter.key == key && number != nullptr) return *number;
  }
  return 0;
}

Beginning FindBeginning(std::string_view type) {
  const Effect* effect = FindEffect(type);
  return effect == nullptr ? kRunning : effect->beginning;
}

bool IsInterruptible(std::string_view type) { return type != "pick" && type != "drop"; }

ActionResult Execute(const ActionCall& call, RobotState& state, const ProtocolTerms& terms) {
  const Effect* effect = FindEffect(call.type);
  return effect == nullptr || effect->execute == nullptr ? ActionResult{}
                                                         : effect->execute(call, state, terms);
}

}  // namespace fleetpub::simulator
