// `fleetpub actions [NAME]`: the catalogue.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>

#include "base/json.h"
#include "base/text.h"
#include "cli/parser/help.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/parser/try_command.h"
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

struct ActionsOptions {
  std::string name;
  std::string version = "3.0.0";
  Option version_option;
};

Result<ExitCode> ListAll(vda5050::Version version, const Context& context) {
  if (!context.output.json()) {
    context.output.PeopleLine(
        fmt::format("Predefined actions of VDA 5050 {} ([optional] parameters):",
                    vda5050::GetFacts(version).name));
  }
  for (const ActionSpec* action : vda5050::ListActions(version)) {
    if (context.output.json()) {
      context.output.Line(ActionJson(*action, version));
      continue;
    }
    const std::string parameters = ParametersText(*action);
    context.output.Line(fmt::format("{:<20} {:<15}{}{}", action->type, ScopesText(action->scopes),
                                    parameters.empty() ? "" : " ", parameters));
  }
  return ExitCode::kDone;
}

// What holds in one version.
struct ActionRow {
  vda5050::Version version;
  const ActionSpec* action;
};

void ShowColumns(std::string_view left, std::string_view right, Output& output) {
  std::string line = TwoColumns(left, right);
  line.pop_back();
  output.Line(line);
}

// A line for each way in which versions differ: `2.1.0 to 3.0.0  stateRequest, instant`.
void ShowVersions(std::span<const ActionRow> rows, Output& output) {
  const auto describe = [](const ActionSpec& action) {
    return fmt::format("{}, {}{}{}", action.type, ScopesText(action.scopes),
                       action.linked_state.empty() ? "" : "; shown by ", action.linked_state);
  };
  for (std::size_t first = 0, i = 0; i < rows.size(); ++i) {
    const std::string text = describe(*rows[i].action);
    if (i + 1 < rows.size() && describe(*rows[i + 1].action) == text) continue;
    const std::string_view from = vda5050::GetFacts(rows[first].version).name;
    const std::string_view to = vda5050::GetFacts(rows[i].version).name;
    ShowColumns(from == to ? std::string(to) : fmt::format("{} to {}", from, to), text, output);
    first = i + 1;
  }
}

void Explain(std::span<const ActionRow> rows, Output& output) {
  const ActionSpec& newest = *rows.back().action;
  std::vector<std::string> names = {std::string(newest.type)};
  for (const std::string_view name : vda5050::ListShortNames(newest.type)) names.emplace_back(name);
  output.Line(fmt::format("{}: {}.", base::Join(names, ", "), newest.summary));
  if (!newest.counter_action.empty()) {
    output.Line(fmt::format("Undone by {}.", newest.counter_action));
  }
  output.Line("Versions:");
  ShowVersions(rows, output);
  const auto parameters = vda5050::ParametersInAnyVersion(newest.type);
  output.Line(parameters.empty() ? "No parameters." : "Parameters:");
  for (const auto& parameter : parameters) {
    std::vector<std::string> lacking;
    for (const ActionRow& row : rows) {
      const auto& own = row.action->parameters;
      const bool has = std::any_of(own.begin(), own.end(),
                                   [&](const auto& p) { return p.name == parameter.name; });
      if (!has) lacking.emplace_back(vda5050::GetFacts(row.version).name);
    }
    const std::string lacks = lacking.empty() ? "" : "; not in " + base::Join(lacking, ", ");
    ShowColumns(
        fmt::format("{} ({})", parameter.name, vda5050::GetName(parameter.type)),
        fmt::format("{}{}{}", parameter.meaning, parameter.required ? "" : " (optional)", lacks),
        output);
  }
  if (!vda5050::IsEverInstant(newest.type)) {
    output.Line("Never an instant action: it belongs to the nodes and edges of an order.");
  }
}

Result<ExitCode> ExplainOne(const ActionsOptions& options, vda5050::Version version,
                            const Context& context) {
  const auto type = vda5050::ActionCalled(options.name);
  if (!type) {
    const auto nearest = vda5050::ActionMeant(options.name);
    return Fail(ErrorKind::kUsage,
                fmt::format("there is no predefined action '{}'{}", base::Printable(options.name),
                            nearest ? fmt::format(": did you mean {}?", *nearest)
                                    : "; " + TryCommand("actions")));
  }
  std::vector<ActionRow> rows;
  for (const vda5050::Version each : vda5050::kVersions) {
    if (options.version_option.IsGiven() && each != version) continue;
    const auto* action = vda5050::FindAction(each, vda5050::NameIn(each, *type));
    if (action != nullptr) rows.push_back({each, action});
  }
  if (rows.empty()) {
    return Fail(ErrorKind::kUsage, fmt::format("VDA 5050 {} has no action {}",
                                               vda5050::GetFacts(version).name, *type));
  }
  if (!context.output.json()) {
    Explain(rows, context.output);
    return ExitCode::kDone;
  }
  for (const ActionRow& row : rows) context.output.Line(ActionJson(*row.action, row.version));
  return ExitCode::kDone;
}

Result<ExitCode> RunActions(const ActionsOptions& options, const Context& context) {
  const auto version = vda5050::ParseVersion(options.version);
  if (!version) return Fail(version.error());
  return options.name.empty() ? ListAll(*version, context) : ExplainOne(options, *version, context);
}

}  // namespace

Run DeclareActions(OptionSet& set) {
  const auto options = std::make_shared<ActionsOptions>();
  set.AddOption("name", options->name, "Only this action, in all versions or the stated one")
      .Type("NAME");
  options->version_option =
      set.AddOption("--vda", VdaVersion(options->version, Automatic::kNo), "Version: {} [3.0.0]")
          .Variable("FLEETPUB_VDA")
          .Group("VDA 5050");
  return [options](const Context& context) { return RunActions(*options, context); };
}

}  // namespace fleetpub::cli
