// `fleetpub pause KIT/0001` and all the other predefined instant actions: options made from the
// catalogue.
#include <fmt/format.h>

#include <map>
#include <memory>

#include "base/text.h"
#include "cli/instant_sending.h"
#include "cli/parser/help.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using vda5050::ParameterSpec;

struct InstantActionOptions {
  std::string type;
  std::vector<ParameterSpec> specs;
  std::map<std::string_view, std::string> texts;  ///< by parameter name, as typed
  std::map<std::string_view, Option> given;
  InstantSendingOptions sending;
};

const char* TypeName(vda5050::ParameterType type) {
  switch (type) {
    case vda5050::ParameterType::kLength:
      return "METRES";
    case vda5050::ParameterType::kAngle:
      return "RADIANS";
    case vda5050::ParameterType::kStringArray:
      return "TEXT,...";
    case vda5050::ParameterType::kString:
      return "TEXT";
  }
  return "TEXT";
}

void DeclareParameter(OptionSet& set, const ParameterSpec& spec, InstantActionOptions& options) {
  const std::string kebab = base::ToKebabCase(spec.name);
  std::string names = fmt::format("--{}", spec.name);
  if (kebab != spec.name) names += fmt::format(",--{}", kebab);
  options.given[spec.name] =
      set.AddOption(names, options.texts[spec.name],
                    fmt::format("{}{}", spec.meaning, spec.required ? "" : " (optional)"))
          .Type(TypeName(spec.type))
          .Group(kParameters);
}

Result<ExitCode> RunInstantAction(const InstantActionOptions& options, const Context& context) {
  std::vector<vda5050::Parameter> parameters;
  for (const ParameterSpec& spec : options.specs) {
    if (!options.given.at(spec.name).IsGiven()) continue;
    auto parameter = vda5050::ParseParameter(spec, options.texts.at(spec.name));
    if (!parameter) return Fail(std::move(parameter.error()));
    parameters.push_back(std::move(*parameter));
  }
  return SendInstantAction(options.sending, options.type, std::move(parameters), context);
}

// The predefined name that the word spells (`initposition` → initPosition); a short name means the
// newest one.
std::string TypeMeantBy(std::string_view word) {
  for (const auto& action : vda5050::AllActions()) {
    if (base::EqualsIgnoringCase(action.type, word)) return std::string(action.type);
  }
  return std::string(vda5050::ActionCalled(word).value_or(word));
}

}  // namespace

Run DeclareInstantAction(OptionSet& set, std::string_view word) {
  const auto options = std::make_shared<InstantActionOptions>();
  options->type = TypeMeantBy(word);
  options->specs = vda5050::ParametersInAnyVersion(options->type);
  for (const ParameterSpec& spec : options->specs) DeclareParameter(set, spec, *options);
  DeclareInstantSendingOptions(set, options->sending);
  if (options->type == "cancelOrder") {
    set.AddFlag("--if-any", options->sending.if_any,
                "With --wait: nothing to cancel is no failure (exit 0)")
        .Group("Waiting");
  }
  if (options->type == "initializePosition" || options->type == "initPosition") {
    set.AddFlag("--force", options->sending.force, "Send one position to several robots")
        .Group("Sending");
  }
  return [options](const Context& context) { return RunInstantAction(*options, context); };
}

}  // namespace fleetpub::cli
