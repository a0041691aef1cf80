// F and V: the topics `factsheet` and `visualization`.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "app/conformance/case.h"
#include "base/text.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::app::conformance {
namespace {

using base::FindMember;
using vda5050::Version;
using Value = base::JsonValue;

CaseFinding CheckRetained(Run& run) {
  constexpr seconds kPatience{2};
  const auto found = run.Of("factsheet");
  for (const Heard* one : found) {
    if (one->message.retained && one->at <= run.began() + kPatience) {
      return Pass("it was there on subscribing", {one->Evidence()});
    }
  }
  if (!found.empty()) return Fault("it comes, but is not retained", {found.front()->Evidence()});
  if (run.last_state() == nullptr) return Inconclusive("the robot was not heard at all");
  return Fault("the robot sends states, and has left no factsheet", {run.last_state()->Evidence()});
}

CaseFinding CheckFactsheetSchema(Run& run) {
  const auto found = run.Of("factsheet");
  if (found.empty()) return Inconclusive("no factsheet came");
  const Heard& one = *found.back();
  const auto findings =
      vda5050::CheckMessage(one.json, run.version(), "factsheet", false, run.registry());
  const auto why = DescribeViolation(findings.errors);
  return why.empty() ? Pass("it keeps its schema", {one.Evidence()}) : Fault(why, {one.Evidence()});
}

CaseFinding CheckActions(Run& run) {
  const auto found = run.Of("factsheet");
  if (found.empty()) return Inconclusive("no factsheet came");
  const auto sheet = vda5050::ReadFactsheet(found.back()->json);
  for (const std::string_view type : {"cancelOrder", "startPause", "stopPause"}) {
    if (vda5050::FindAction(sheet, type) == nullptr) {
      return Fault(fmt::format("{} is not in mobileRobotActions", type),
                   {found.back()->Evidence()});
    }
  }
  return Pass("they are listed", {found.back()->Evidence()});
}

double VisualizationInterval(Run& run) {
  const auto sheets = run.Of("factsheet");
  if (sheets.empty()) return 0;
  const Value* limits = FindMember(sheets.back()->json, "protocolLimits");
  const Value* timing = limits == nullptr ? nullptr : FindMember(*limits, "timing");
  const Value* interval =
      timing == nullptr ? nullptr : FindMember(*timing, "visualizationInterval");
  return interval != nullptr && interval->IsNumber() ? interval->GetDouble() : 0;
}

// They have QoS 0, so that one may be lost: half of them are enough.
CaseFinding CheckInterval(Run& run) {
  const double interval = VisualizationInterval(run);
  if (interval <= 0) return Skipped("its factsheet promises none");
  const std::chrono::duration<double> listened = run.Now() - run.began();
  const double due = listened.count() / (interval * 1.5);
  if (due < 2) return Inconclusive("too short: listen for longer");
  const auto found = run.Of("visualization");
  const std::string text = fmt::format("{} in {:.0f} s, one each {} s promised", found.size(),
                                       listened.count(), interval);
  constexpr double kCertain = 10;  // not all of so many are lost
  if (found.empty()) return due < kCertain ? Inconclusive(text) : Fault(text);
  std::uint32_t sent = 0;
  if (found.front()->header.header_id && found.back()->header.header_id) {
    sent = *found.back()->header.header_id - *found.front()->header.header_id + 1;
  }
  if (static_cast<double>(found.size()) >= due) return Pass(text);
  if (sent > found.size()) return Inconclusive(text + "; some were lost");
  return Fault(text, {found.back()->Evidence()});
}

CaseFinding CheckReference(Run& run) {
  const auto found = run.Of("visualization");
  if (found.empty()) return Skipped("it sends none");
  std::set<std::uint32_t> known;
  for (const Heard& one : run.heard()) {
    if (one.topic_name == "state" && one.header.header_id) known.insert(*one.header.header_id);
    if (one.topic_name != "visualization") continue;
    const Value* reference = FindMember(one.json, "referenceStateHeaderId");
    if (reference == nullptr || !reference->IsUint()) {
      return Fault("referenceStateHeaderId is missing", {one.Evidence()});
    }
    if (!known.empty() && reference->GetUint() > *known.rbegin() + 100) {
      return Fault(fmt::format("no state had headerId {}", reference->GetUint()), {one.Evidence()});
    }
  }
  return Pass(base::Counted(found.size(), "message"));
}

using enum Version;
constexpr auto kFactsheetCases = std::to_array<Case>({
    {"F01", Level::kListen, k200, k300, "6.10 / 6.15", "factsheet is retained", "2 s",
     "publish it with the retain flag, at every connect", CheckRetained},
    {"F02", Level::kListen, k200, k300, "7.10 / 6.15", "factsheet keeps its schema", "",
     "fleetpub validate factsheet -f FILE shows every violation", CheckFactsheetSchema},
    {"F03", Level::kListen, k300, k300, "6.2.3",
     "factsheet lists cancelOrder, startPause and stopPause", "",
     "list what every robot must know, too", CheckActions},
    {"V01", Level::kListen, k200, k300, "6.7 / 6.12",
     "visualization comes at the interval that the factsheet promises", "1.5 intervals",
     "send it, or promise none", CheckInterval},
    {"V02", Level::kListen, k300, k300, "7.9",
     "visualization names a state by referenceStateHeaderId", "",
     "write the headerId of the last state", CheckReference},
});

}  // namespace

std::span<const Case> FactsheetCases() { return kFactsheetCases; }

}  // namespace fleetpub::app::conformance
