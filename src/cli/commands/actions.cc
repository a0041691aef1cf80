// `fleetpub actions`: the catalogue.
#include <fmt/format.h>

#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using vda5050::ActionSpec;

std::string ScopesText(const vda5050::Scopes& scopes) {
  std::vector<std::string> names;
  if (scopes.instant) names.emplace_back("instant");
  if (scopes.node) names.emplace_back("node");
  if (scopes.edge) names.emplace_back("edge");
  if (scopes.zone) names.emplace_back("zone");
  return base::Join(names, ",");
}

std::string ParametersText(const ActionSpec& action) {
  std::vector<std::string> names;
  for (const auto& parameter : action.parameters) {
    names.push_back(parameter.required ? std::string(parameter.name)
                                       : fmt::format("[{}]", parameter.name));
  }
  return base::Join(names, " ");
}

std::string ActionJson(const ActionSpec& action, vda5050::Version version) {
  std::string parameters;
  for (const auto& parameter : action.parameters) {
    parameters +=
        fmt::format(R"({}{{"name":"{}","type":"{}","required":{}}})", parameters.empty() ? "" : ",",
                    parameter.name, vda5050::GetName(parameter.type), parameter.required);
  }
  return fmt::format(
      R"({{"actionType":"{}","version":"{}","instant":{},"node":{},"edge":{},"zone":{},)"
      R"("parameters":[{}],"counterAction":"{}","linkedState":"{}","idempotent":{},)"
      R"("summary":{}}})",
      action.type, vda5050::GetFacts(version).name, action.scopes.instant, action.scopes.node,
      action.scopes.edge, action.scopes.zone, parameters, action.counter_action,
      action.linked_state, action.idempotent, base::JsonString(action.summary));
}

Result<ExitCode> RunActions(const std::string& version_text, const Context& context) {
  const auto version = vda5050::ParseVersion(version_text);
  if (!version) return Fail(version.error());
  if (!context.output.json()) {
    context.output.PeopleLine(
        fmt::format("Predefined actions of VDA 5050 {} ([optional] parameters):",
                    vda5050::GetFacts(*version).name));
  }
  for (const ActionSpec* action : vda5050::ListActions(*version)) {
    if (context.output.json()) {
      context.output.Line(ActionJson(*action, *version));
      continue;
    }
    const std::string parameters = ParametersText(*action);
    context.output.Line(fmt::format("{:<20} {:<15}{}{}", action->type, ScopesText(action->scopes),
                                    parameters.empty() ? "" : " ", parameters));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareActions(OptionSet& set) {
  const auto version = std::make_shared<std::string>("3.0.0");
  set.AddOption("--vda", VdaVersion(*version, Automatic::kNo), "Version: {} [3.0.0]")
      .Variable("FLEETPUB_VDA")
      .Group("VDA 5050");
  return [version](const Context& context) { return RunActions(*version, context); };
}

}  // namespace fleetpub::cli
