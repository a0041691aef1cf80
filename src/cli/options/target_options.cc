#include "cli/options/target_options.h"

#include <fmt/format.h>

#include "cli/parser/option_set.h"

namespace fleetpub::cli {
namespace {

Result<std::vector<vda5050::Condition>> ParseConditions(const std::vector<std::string>& texts) {
  std::vector<vda5050::Condition> conditions;
  for (const std::string& text : texts) {
    auto condition = vda5050::ParseCondition(text);
    if (!condition) {
      condition.error().message = "--where: " + condition.error().message;
      return Fail(std::move(condition.error()));
    }
    conditions.push_back(*std::move(condition));
  }
  return conditions;
}

constexpr const char* kTargets = "Targets";

}  // namespace

void DeclareTargetWords(OptionSet& set, TargetOptions& o, std::string_view otherwise) {
  set.AddOption(
         "targets", o.words,
         fmt::format("Robots: manufacturer/serialNumber, alias, @group, 'KIT/*', - (standard "
                     "input){}",
                     otherwise))
      .Type("TARGET");
}

void DeclareSelectionFlags(OptionSet& set, TargetOptions& o) {
  set.AddFlag("--all", o.all, "All robots that the broker knows").Group(kTargets);
  set.AddFlag("--patterns", o.patterns, "Lines of standard input may be patterns and groups too")
      .Group(kTargets);
  // Without OneValueEach() they would swallow the targets behind them.
  set.AddOption("--except", o.except, "Leave out this robot, alias, @group or pattern; repeatable")
      .Type("TARGET")
      .OneValueEach()
      .Group(kTargets);
  set.AddOption("--where", o.where,
                "Only robots of which this is true: 'battery<20', operatingMode=AUTOMATIC; "
                "repeatable")
      .Type("CONDITION")
      .OneValueEach()
      .Group(kTargets);
  DeclareOnline(set, o.online);
}

void DeclareOnline(OptionSet& set, bool& online) {
  set.AddFlag("--online", online, "Only robots that are online: others are no failure")
      .Group(kTargets);
}

void DeclareTargetOptions(OptionSet& set, TargetOptions& o) {
  DeclareTargetWords(set, o);
  DeclareSelectionFlags(set, o);
  set.AddOption("--state-wait", Duration(o.state_wait),
                "How long --where waits for the states of robots that are online [35s]")
      .Group(kTargets);
  set.AddOption("--expect", WholeNumber(o.expect, 1, 1'000'000),
                "Send nothing unless exactly so many robots are meant")
      .Group(kTargets);
}

void DeclareSelectionOptions(OptionSet& set, TargetOptions& o) {
  DeclareTargetWords(set, o, " [all]");
  DeclareSelectionFlags(set, o);
}

Result<app::TargetRequest> ParseTargetOptions(const TargetOptions& options) {
  auto where = ParseConditions(options.where);
  if (!where) return Fail(std::move(where.error()));
  return app::TargetRequest{.words = options.words,
                            .patterns = options.patterns,
                            .all = options.all,
                            .except = options.except,
                            .where = *std::move(where),
                            .online = options.online,
                            .state_wait = options.state_wait.value_or(vda5050::kLongestSilence),
                            .expect = options.expect};
}

}  // namespace fleetpub::cli
