// I: instant actions that move nothing.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/conformance/case.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::ActionState;
using vda5050::RobotError;
using vda5050::RobotState;
using vda5050::Shown;
using vda5050::Version;

bool Names(const RobotError& error, std::string_view id) {
  return std::any_of(error.references.begin(), error.references.end(),
                     [&](const auto& reference) { return reference.value == id; });
}

// The action came to its end: this one, and told in time.
CaseFinding CheckEnd(const Awaited& awaited, const std::string& id, std::string_view status) {
  if (awaited.found == nullptr) return Run::Missing(awaited, "no state shows how the action ended");
  const ActionState* action = vda5050::FindActionState(*awaited.found->state, id);
  if (action->status == status) {
    return Pass(fmt::format("it ended {}", status), {awaited.found->Evidence()});
  }
  return Fault(fmt::format("it ended {}, not {}", Shown(action->status), status),
               {awaited.found->Evidence()});
}

CaseFinding CheckStateRequest(Run& run) {
  const TimePoint from = run.Now();
  const std::size_t mark = run.mark();
  const std::string id = run.Do("stateRequest");
  const auto awaited = run.AwaitSince(mark, from, ShowsEnd(id), kNextState);
  if (awaited.found != nullptr && awaited.is_late && !awaited.has_hole) {
    return Fault("no state came within 5 s", {awaited.found->Evidence()});
  }
  return CheckEnd(awaited, id, "FINISHED");
}

CaseFinding CheckFactsheetRequest(Run& run) {
  if (run.Knows("factsheetRequest", "INSTANT") == false)
    return Skipped("its factsheet has no such action");
  // It has QoS 0: one may be lost.
  for (int attempt = 0; attempt < 3; ++attempt) {
    const std::size_t mark = run.mark();
    const std::string id = run.Do("factsheetRequest");
    auto finding = CheckEnd(run.Await(ShowsEnd(id)), id, "FINISHED");
    if (finding.verdict != Verdict::kPass) return finding;
    run.Listen(seconds(1));
    for (std::size_t i = mark; i < run.heard().size(); ++i) {
      const Heard& one = run.heard()[i];
      if (one.topic_name == "factsheet") return Pass("it came", {one.Evidence()});
    }
  }
  return Fault("three of them are FINISHED, but no factsheet came", {run.last_state()->Evidence()});
}

// Also in time: what is due is due with the next state.
CaseFinding CheckReported(Run& run) {
  const TimePoint from = run.Now();
  const std::size_t mark = run.mark();
  const std::string id = run.Do("stopPause");
  const auto awaited = run.AwaitSince(
      mark, from,
      [&](const RobotState& state) { return vda5050::FindActionState(state, id) != nullptr; },
      kNextState);
  if (awaited.found == nullptr) return Run::Missing(awaited, "no state has its actionId");
  if (awaited.is_late && !awaited.has_hole) {
    return Fault("no state came within 5 s", {awaited.found->Evidence()});
  }
  return Pass("a state has its actionId", {awaited.found->Evidence()});
}

constexpr std::string_view kUnknown = "fleetpubConformanceTest";

CaseFinding CheckUnknown(Run& run) {
  const std::string id = run.Do(kUnknown);
  const auto awaited = run.Await([&](const RobotState& state) {
    const ActionState* action = vda5050::FindActionState(state, id);
    return (action != nullptr && action->status == "FAILED") ||
           std::any_of(state.errors.begin(), state.errors.end(),
                       [&](const RobotError& error) { return Names(error, id); });
  });
  if (awaited.found == nullptr) {
    return Run::Missing(awaited, "no error and no state names the unknown action");
  }
  const RobotState& state = *awaited.found->state;
  const bool is_named = std::any_of(state.errors.begin(), state.errors.end(),
                                    [&](const RobotError& error) { return Names(error, id); });
  if (!run.Is30()) {
    return is_named ? Pass("an error names it", {awaited.found->Evidence()})
                    : Fault("it is FAILED, but no error names it", {awaited.found->Evidence()});
  }
  const ActionState* action = vda5050::FindActionState(state, id);
  if (action == nullptr) return Fault("it has no action state", {awaited.found->Evidence()});
  const auto error = std::find_if(state.errors.begin(), state.errors.end(),
                                  [&](const RobotError& one) { return Names(one, id); });
  if (error == state.errors.end()) {
    return Fault("it is FAILED, but no error names it", {awaited.found->Evidence()});
  }
  if (error->type != "INVALID_INSTANT_ACTION") {
    return Fault("the error is " + Shown(error->type), {awaited.found->Evidence()});
  }
  return Pass("it is FAILED, and INVALID_INSTANT_ACTION names it", {awaited.found->Evidence()});
}

CaseFinding CheckTwice(Run& run) {
  const std::string id = run.Do("stopPause");
  const auto first = run.Await(ShowsEnd(id));
  if (first.found == nullptr) return Inconclusive("it did not end the first time");
  const std::size_t mark = run.mark();
  run.Do("stopPause", {}, id);
  run.Refresh();
  for (const Heard* one : run.StatesSince(mark)) {
    std::size_t entries = 0;
    for (const auto* list : {&one->state->action_states, &one->state->instant_action_states}) {
      entries += static_cast<std::size_t>(std::count_if(
          list->begin(), list->end(), [&](const ActionState& action) { return action.id == id; }));
    }
    if (entries > 1) return Fault(fmt::format("{} entries", entries), {one->Evidence()});
    if (entries == 1) return Pass("one entry", {one->Evidence()});
  }
  return Inconclusive("no state shows it any more");
}

CaseFinding CheckPaused(Run& run, std::string_view type, bool paused) {
  constexpr seconds kPause{10};
  const std::string id = run.Do(type);
  auto finding = CheckEnd(run.Await(ShowsEnd(id), kPause), id, "FINISHED");
  if (finding.verdict != Verdict::kPass) return finding;
  const Heard& last = *run.last_state();
  if (last.state->paused == paused) {
    return Pass(paused ? "paused is true" : "paused is false", {last.Evidence()});
  }
  const auto later = run.Await([&](const RobotState& state) { return state.paused == paused; });
  if (later.found == nullptr) {
    return Run::Missing(later, fmt::format("{} is FINISHED, and paused is not {}", type, paused));
  }
  return Pass("paused follows", {later.found->Evidence()});
}

CaseFinding CheckStartPause(Run& run) {
  auto finding = CheckPaused(run, "startPause", true);
  if (finding.verdict == Verdict::kPass) {
    finding = CheckPaused(run, "startPause", true);
    if (finding.verdict == Verdict::kFail) finding.why = "the second time: " + finding.why;
  }
  (void)CheckPaused(run, "stopPause", false);
  return finding;
}

CaseFinding CheckStopPause(Run& run) {
  const auto paused = CheckPaused(run, "startPause", true);
  auto finding = CheckPaused(run, "stopPause", false);
  if (finding.verdict == Verdict::kPass && paused.verdict != Verdict::kPass) {
    return Inconclusive("it was not paused before");
  }
  return finding;
}

bool DrivesNowhere(const Run& run) {
  const Heard* last = run.last_state();
  return last != nullptr && last->state->nodes_left == 0U &&
         last->state->edges_left.value_or(0) == 0;
}

CaseFinding CheckCancelIdle(Run& run) {
  run.Refresh();
  if (!DrivesNowhere(run)) return Inconclusive("it has an order");
  const std::string id = run.Do("cancelOrder");
  const auto awaited = run.Await(ShowsEnd(id));
  auto finding = CheckEnd(awaited, id, "FAILED");
  if (finding.verdict != Verdict::kPass) return finding;
  const std::string_view type = run.Is30() ? "NO_ORDER_TO_CANCEL" : "noOrderToCancel";
  const auto& errors = awaited.found->state->errors;
  const auto named = std::find_if(errors.begin(), errors.end(),
                                  [&](const RobotError& error) { return Names(error, id); });
  const auto typed = std::find_if(errors.begin(), errors.end(),
                                  [&](const RobotError& error) { return error.type == type; });
  if (typed == errors.end()) {
    return Fault(fmt::format("it is FAILED, without {}", type), {awaited.found->Evidence()});
  }
  if (named == errors.end()) {
    return Fault("its error does not name the actionId", {awaited.found->Evidence()});
  }
  return Pass(fmt::format("FAILED with {}", type), {awaited.found->Evidence()});
}

CaseFinding CheckInstantActionsKept(Run& run) {
  const std::string id = run.Do("stopPause");
  if (run.Await(ShowsEnd(id)).found == nullptr) return Inconclusive("it did not end");
  for (int i = 0; i < 3; ++i) {
    const auto next = run.Await([](const RobotState&) { return true; }, seconds(0));
    if (next.found == nullptr) return Inconclusive("no further state came");
    if (vda5050::FindActionState(*next.found->state, id) == nullptr) {
      return Fault("it has left the state, without clearInstantActions", {next.found->Evidence()});
    }
  }
  return Pass("it stays over three states", {run.last_state()->Evidence()});
}

CaseFinding CheckClear(Run& run) {
  if (run.Knows("clearInstantActions", "INSTANT") == false) {
    return Skipped("its factsheet has no such action");
  }
  const std::string old = run.Do("stopPause");
  if (run.Await(ShowsEnd(old)).found == nullptr) return Inconclusive("nothing was there to clear");
  const std::string id = run.Do("clearInstantActions");
  const auto gone = run.Await(
      [&](const RobotState& state) { return vda5050::FindActionState(state, old) == nullptr; });
  if (gone.found == nullptr) return Run::Missing(gone, "ended instant actions stay");
  return Pass("they are gone", {gone.found->Evidence()});
}

CaseFinding CheckGarbage(Run& run) {
  run.SendGarbage();
  run.Listen(seconds(1));
  const std::string id = run.Do("stateRequest");
  const auto awaited = run.Await(ShowsEnd(id));
  if (awaited.found == nullptr)
    return Run::Missing(awaited, "after it the robot does nothing more");
  return Pass("it goes on", {awaited.found->Evidence()});
}

using enum Version;
constexpr Level kActions = Level::kActions;
constexpr auto kInstantActionCases = std::to_array<Case>({
    {"I01", kActions, k110, k300, "6.2.3 / 6.8", "stateRequest brings a state and is FINISHED",
     "5 s", "send the state in which it is FINISHED", CheckStateRequest},
    {"I02", kActions, k200, k300, "6.10 / 6.15",
     "factsheetRequest brings a factsheet and is FINISHED", "5 s",
     "publish it anew, also when it is retained", CheckFactsheetRequest},
    {"I03", kActions, k110, k300, "6.2.1 / 6.9", "an instant action is reported with its actionId",
     "next state", "send a state when an action's state changes", CheckReported},
    {"I04", kActions, k110, k210, "7.1", "an unknown action brings an error that names it",
     "next state", "reference the actionId", CheckUnknown},
    {"I05", kActions, k300, k300, "6.2.1",
     "an unknown action is FAILED, and INVALID_INSTANT_ACTION names it", "next state",
     "report both, with the actionId as reference", CheckUnknown},
    {"I06", kActions, k110, k300, "6.2 / 6.9", "an actionId that comes twice has one entry",
     "next state", "ignore an instant action whose actionId is known", CheckTwice},
    {"I07", kActions, k110, k300, "6.2.3 / 6.8",
     "startPause makes paused true and is FINISHED, also when it is paused", "10 s",
     "what is as wanted already is FINISHED", CheckStartPause},
    {"I08", kActions, k110, k300, "6.2.3 / 6.8", "stopPause makes paused false", "10 s",
     "report paused with the action's end", CheckStopPause},
    {"I09", kActions, k110, k300, "6.1.3.2 / 6.6.3.2",
     "cancelOrder without an order is FAILED, and an error names it", "next state",
     "report noOrderToCancel, from 3.0 NO_ORDER_TO_CANCEL, with the actionId", CheckCancelIdle},
    {"I10", kActions, k300, k300, "7.8", "ended instant actions stay until they are cleared",
     "3 states", "keep them until clearInstantActions", CheckInstantActionsKept},
    {"I11", kActions, k300, k300, "6.2.3", "clearInstantActions clears the ended ones",
     "next state", "remove all that are FINISHED or FAILED", CheckClear},
    {"I12", kActions, k110, k300, "–", "a message that is no JSON changes nothing", "35 s",
     "pass over what cannot be parsed", CheckGarbage},
});

}  // namespace

std::span<const Case> InstantActionCases() { return kInstantActionCases; }

}  // namespace fleetpub::app::conformance
