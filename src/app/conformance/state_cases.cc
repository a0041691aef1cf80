// S: the topic `state`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "app/conformance/case.h"
#include "base/text.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::app::conformance {
namespace {

using base::FindArray;
using base::FindMember;
using vda5050::RobotError;
using vda5050::RobotState;
using vda5050::Shown;
using vda5050::Version;
using Value = base::JsonValue;

std::vector<const Heard*> Live(Run& run) { return run.StatesSince(0); }

bool Stops(const RobotError& error) { return error.level == "CRITICAL" || error.level == "FATAL"; }

// A factsheet's number, in s; 0: it has none.
double Timing(Run& run, std::string_view old_name, std::string_view name) {
  const auto sheets = run.Of("factsheet");
  if (sheets.empty()) return 0;
  const Value* limits = FindMember(sheets.back()->json, "protocolLimits");
  const Value* timing = limits == nullptr ? nullptr : FindMember(*limits, "timing");
  if (timing == nullptr) return 0;
  const Value* number = FindMember(*timing, old_name);
  if (number == nullptr) number = FindMember(*timing, name);
  return number != nullptr && number->IsNumber() ? number->GetDouble() : 0;
}

CaseFinding CheckStateSchema(Run& run) {
  const auto states = Live(run);
  if (states.empty()) return Inconclusive("no state came");
  for (const Heard* one : states) {
    const auto found =
        vda5050::CheckMessage(one->json, run.version(), "state", false, run.registry());
    if (const auto why = DescribeViolation(found.errors); !why.empty()) {
      return Fault(why, {one->Evidence()});
    }
    const auto& position = one->state->position;
    if (position && position->theta && std::abs(*position->theta) > std::numbers::pi + 0.001) {
      return Fault(fmt::format("theta is {}, beyond ±π", *position->theta), {one->Evidence()});
    }
  }
  return Pass(base::Counted(states.size(), "state"));
}

CaseFinding CheckLongest(Run& run) {
  const auto states = Live(run);
  if (states.empty()) return Inconclusive("no state came");
  const double usual = Timing(run, "defaultStateInterval", "defaultStateInterval");
  const auto limit = std::chrono::duration<double>(usual > 30 ? 1.2 * usual : 35);
  TimePoint last = run.began();
  std::chrono::duration<double> longest{0};
  for (std::size_t i = 0; i <= states.size(); ++i) {
    const TimePoint at = i < states.size() ? states[i]->at : run.Now();
    longest = std::max<std::chrono::duration<double>>(longest, at - last);
    if (at - last > limit) {
      const bool lost = i == states.size() || run.HasHole(0);
      const std::string text = fmt::format("{:.0f} s without a state", longest.count());
      if (lost) return Inconclusive(text + ": some may be lost");
      return Fault(text, {states[i]->Evidence()});
    }
    last = at;
  }
  if (run.Now() - run.began() < seconds(31)) {
    return Inconclusive("too short: listen for 31 s or more");
  }
  return Pass(fmt::format("{:.0f} s at most", longest.count()));
}

CaseFinding CheckShortest(Run& run) {
  const double limit = Timing(run, "minStateInterval", "minimumStateInterval");
  if (limit <= 0) return Skipped("its factsheet sets no limit");
  const auto states = Live(run);
  if (states.size() < 2) return Inconclusive("fewer than two states came");
  std::size_t early = 0;
  const Heard* which = nullptr;
  for (std::size_t i = 1; i < states.size(); ++i) {
    const std::chrono::duration<double> gap = states[i]->at - states[i - 1]->at;
    if (gap.count() >= limit * 0.8) continue;  // they may catch up on the way
    ++early;
    which = states[i];
  }
  if (early * 10 > states.size()) {
    return Fault(fmt::format("{} of {} states came sooner than {} s after another", early,
                             states.size(), limit),
                 {which->Evidence()});
  }
  return Pass(base::Counted(states.size(), "state"));
}

// The sequenceIds of an array's items, and whether each is released; nothing: they cannot be read.
struct Leg {
  std::uint32_t id;
  bool released;
};
std::vector<Leg> ReadLegs(const Value& state, std::string_view list) {
  std::vector<Leg> legs;
  const Value* array = FindArray(state, list);
  if (array == nullptr) return legs;
  for (const Value& item : array->GetArray()) {
    const Value* id = FindMember(item, "sequenceId");
    const Value* released = FindMember(item, "released");
    if (id == nullptr || !id->IsUint()) continue;
    legs.push_back(
        {id->GetUint(), released == nullptr || !released->IsBool() || released->GetBool()});
  }
  return legs;
}

std::string FindDisorder(std::span<const Leg> legs, std::uint32_t parity) {
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (legs[i].id % 2 != parity) return "a sequenceId has the wrong parity";
    if (i > 0 && legs[i].id <= legs[i - 1].id) return "sequenceIds do not ascend";
    if (i > 0 && legs[i].released && !legs[i - 1].released)
      return "the base comes after the horizon";
  }
  return {};
}

// Node and edge by turns: as nodes are even and edges odd, no two neighbours are alike.
bool DoAlternate(std::span<const Leg> nodes, std::span<const Leg> edges) {
  std::set<std::uint32_t> ids;
  for (const auto& legs : {nodes, edges}) {
    for (const Leg& leg : legs) ids.insert(leg.id);
  }
  return std::adjacent_find(ids.begin(), ids.end(), [](std::uint32_t a, std::uint32_t b) {
           return (b - a) % 2 == 0;
         }) == ids.end();
}

CaseFinding CheckOrderOfLegs(Run& run) {
  bool any = false;
  for (const Heard* one : Live(run)) {
    const auto nodes = ReadLegs(one->json, "nodeStates");
    const auto edges = ReadLegs(one->json, "edgeStates");
    any = any || !nodes.empty();
    auto fault = FindDisorder(nodes, 0);
    if (fault.empty()) fault = FindDisorder(edges, 1);
    if (fault.empty() && !DoAlternate(nodes, edges)) fault = "they do not alternate";
    if (!fault.empty()) return Fault("nodeStates, edgeStates: " + fault, {one->Evidence()});
  }
  return any ? Pass("in order") : Inconclusive("no state showed a way ahead");
}

CaseFinding CheckNoOrder(Run& run) {
  bool any = false;
  for (const Heard* one : Live(run)) {
    const Value* id = FindMember(one->json, "orderId");
    if (id == nullptr || !id->IsString()) {
      return Fault("orderId is no text: without an order it is \"\"", {one->Evidence()});
    }
    if (id->GetStringLength() > 0)
      return any ? Pass("it says so") : Inconclusive("it has an order");
    any = true;
    if (one->state->order_update_id != 0U) {
      return Fault("orderId is \"\", but orderUpdateId is not 0", {one->Evidence()});
    }
  }
  return any ? Pass("it says so") : Inconclusive("no state came");
}

CaseFinding CheckInstantStates(Run& run) {
  const auto states = Live(run);
  if (states.empty()) return Inconclusive("no state came");
  for (const Heard* one : states) {
    if (!one->state->has_instant_action_states) {
      return Fault("instantActionStates is missing", {one->Evidence()});
    }
    for (const auto& action : one->state->action_states) {
      if (run.IsInstant(action.id)) {
        return Fault("an instant action stands in actionStates", {one->Evidence()});
      }
    }
  }
  return Pass(base::Counted(states.size(), "state"));
}

CaseFinding CheckLocalized(Run& run) {
  bool any = false;
  for (const Heard* one : Live(run)) {
    const RobotState& state = *one->state;
    if (!state.position || !state.position->localized) continue;
    any = true;
    const bool is_told =
        std::any_of(state.errors.begin(), state.errors.end(), [](const RobotError& error) {
          return error.type == "LOCALIZATION_ERROR" && error.level == "FATAL";
        });
    if (*state.position->localized == is_told) {
      return Fault(is_told ? "LOCALIZATION_ERROR, but localized is true"
                           : "localized is false, without LOCALIZATION_ERROR FATAL",
                   {one->Evidence()});
    }
    if (is_told && state.driving.value_or(false)) {
      return Fault("it drives without being localized", {one->Evidence()});
    }
  }
  return any ? Pass("they agree") : Inconclusive("no state says whether it is localized");
}

// It may take the next state to stop.
CaseFinding CheckStops(Run& run) {
  bool any = false;
  const Heard* before = nullptr;
  for (const Heard* one : Live(run)) {
    const RobotState& state = *one->state;
    if (std::none_of(state.errors.begin(), state.errors.end(), Stops)) {
      before = nullptr;
      continue;
    }
    any = true;
    if (!state.driving.value_or(false)) continue;
    if (before != nullptr) return Fault("it drives on with such an error", {one->Evidence()});
    before = one;
  }
  return any ? Pass("it stands") : Inconclusive("no such error occurred");
}

CaseFinding CheckErrorTypes(Run& run) {
  constexpr auto kOld = std::to_array<std::string_view>(
      {"validationError", "validationOrder", "orderError", "orderUpdateError", "noRouteError",
       "noOrderToCancel", "controlError", "instantActionError"});
  bool any = false;
  for (const Heard* one : Live(run)) {
    for (const RobotError& error : one->state->errors) {
      any = true;
      if (std::find(kOld.begin(), kOld.end(), error.type) != kOld.end()) {
        return Fault(Shown(error.type) + " is a name of 2.x", {one->Evidence()});
      }
    }
  }
  return any ? Pass("no old name") : Inconclusive("no error occurred");
}

using enum Version;
constexpr auto kStateCases = std::to_array<Case>({
    {"S01", Level::kListen, k110, k300, "7.8 / 6.10", "state keeps its schema, theta is within ±π",
     "", "fleetpub validate --live shows every violation", CheckStateSchema},
    {"S02", Level::kListen, k110, k300, "6.6 / 6.10", "a state comes at least every 30 s", "35 s",
     "send a state 30 s after the last one, whatever happened", CheckLongest},
    {"S03", Level::kListen, k200, k300, "6.6 / 6.10",
     "states keep the shortest interval of the factsheet", "", "put events of one moment together",
     CheckShortest},
    {"S04", Level::kListen, k110, k300, "6.1.1 / 6.6",
     "nodeStates and edgeStates ascend, alternate, even and odd, the base first", "",
     "keep both arrays in the order's order", CheckOrderOfLegs},
    {"S05", Level::kListen, k110, k300, "7.8 / 6.10",
     "before its first order orderId is \"\" and orderUpdateId 0", "", "not null, not \"-1\"",
     CheckNoOrder},
    {"S06", Level::kListen, k300, k300, "7.8", "instant actions stand in instantActionStates", "",
     "keep them apart from the order's actionStates", CheckInstantStates},
    {"S07", Level::kListen, k300, k300, "7.8",
     "localized is false exactly while LOCALIZATION_ERROR FATAL is reported", "",
     "report the error, and do not drive", CheckLocalized},
    {"S08", Level::kListen, k300, k300, "6.6.5.1", "with a CRITICAL or FATAL error it stands",
     "next state", "stop before or with the state that reports the error", CheckStops},
    {"S09", Level::kListen, k300, k300, "6.6.5.4", "errorType has the names of 3.0", "",
     "VALIDATION_FAILURE, not validationError", CheckErrorTypes},
    {"S10", Level::kListen, k110, k300, "6.6 / 6.10",
     "a pressed emergency stop shows in safetyState", "next state", "send a state at once",
     nullptr},
    {"S11", Level::kListen, k110, k300, "6.6 / 6.10", "a switched mode shows in operatingMode",
     "next state", "send a state at once", nullptr},
});

}  // namespace

std::span<const Case> StateCases() { return kStateCases; }

}  // namespace fleetpub::app::conformance
