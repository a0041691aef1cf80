// The cases one by one, in an order that leaves each what it needs.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "app/conformance/case.h"
#include "app/conformance/orders.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

constexpr seconds kBeginning{35};  // until its first state

bool Matches(const std::vector<std::string>& words, std::string_view id) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return base::EqualsIgnoringCase(word, id) ||
           (word.size() == 1 && base::EqualsIgnoringCase(word, id.substr(0, 1)));
  });
}

// Why it is not run; "": it is.
std::string ReasonToSkip(const Case& one, const Selection& selection) {
  if (one.check == nullptr) return "a person has to act";
  if (one.level > selection.level) return fmt::format("needs --level {}", GetName(one.level));
  return {};
}

CaseFinding CheckActive(const Case& one, Run& run) {
  if (!run.abort_reason().empty()) return Inconclusive("not run: " + run.abort_reason());
  auto finding = one.check(run);
  // What ended the run says more than what did not come for it, and a case cut short passes nothing.
  if (!run.abort_reason().empty() && (run.is_stopped() || finding.verdict != Verdict::kPass)) {
    return Inconclusive("not finished: " + run.abort_reason());
  }
  return finding;
}

// What the robot was left in.
void Restore(Run& run, Level level, std::vector<std::string>& leftover) {
  if (level == Level::kListen || run.last_state() == nullptr) return;
  // What was sent last may be on its way.
  if (run.is_stopped() && run.AwaitOwnActions().found == nullptr) {
    leftover.emplace_back("the robot has not said how it was left. try: fleetpub show");
  }
  const auto is_paused = [&] { return run.last_state()->state->paused.value_or(false); };
  if (is_paused()) {
    run.Do("stopPause");
    (void)run.Await([](const vda5050::RobotState& state) { return state.paused == false; });
  }
  if (level == Level::kDrive) EndOrder(run);
  if (is_paused()) leftover.emplace_back("the robot is still paused. try: fleetpub stopPause");
  if (level == Level::kDrive && !IsIdle(*run.last_state()->state)) {
    leftover.emplace_back("the robot still has an order. try: fleetpub cancel");
  }
  if (run.Once<bool>(kLoaded, [] { return false; })) {
    leftover.emplace_back("the robot still carries the load that it was told to pick");
  }
}

}  // namespace

bool Selection::Has(std::string_view id) const {
  return (only.empty() || Matches(only, id)) && !Matches(skip, id);
}

bool Selection::RunsAny(std::span<const Case> cases) const {
  return std::any_of(cases.begin(), cases.end(), [&](const Case& one) {
    return Has(one.id) && ReasonToSkip(one, *this).empty();
  });
}

std::vector<Case> ListCases() {
  std::vector<Case> all;
  for (const auto& group :
       {ConnectionCases(), HeaderCases(), StateCases(), FactsheetCases(), InstantActionCases(),
        OrderCases(), DrivingCases(), OrderActionCases(), EndingCases()}) {
    std::copy(group.begin(), group.end(), std::back_inserter(all));
  }
  return all;
}

Outcome Conduct(Run& run, const Selection& selection, const Progress& progress) {
  Outcome outcome;
  for (const Case& one : ListCases()) {
    if (one.AppliesTo(run.version()) && selection.Has(one.id)) {
      outcome.results.push_back({one, Skipped(ReasonToSkip(one, selection))});
    }
  }
  const auto check = [&](bool is_active) {
    for (CaseResult& result : outcome.results) {
      const bool is_this = (result.of.level != Level::kListen) == is_active;
      if (!is_this) continue;
      if (result.finding.why.empty()) {
        result.finding = is_active ? CheckActive(result.of, run) : result.of.check(run);
      }
      if (progress) progress(result);
    }
  };
  if (selection.level != Level::kListen) {
    const TimePoint until = run.Now() + kBeginning;
    while (run.last_state() == nullptr && run.Now() < until && run.abort_reason().empty()) {
      run.Listen(milliseconds(200));
    }
    if (run.last_state() == nullptr) run.Abort("the robot sent no state within 35 s");
    if (run.last_state() != nullptr && selection.level == Level::kDrive &&
        !IsIdle(*run.last_state()->state)) {
      run.Abort("the robot has an order already");
    }
  }
  check(true);
  run.TakeBack([&] { Restore(run, selection.level, outcome.leftover); });
  const auto listened = run.Now() - run.began();
  if (listened < selection.listen) run.Listen(selection.listen - listened);
  check(false);
  return outcome;
}

}  // namespace fleetpub::app::conformance
