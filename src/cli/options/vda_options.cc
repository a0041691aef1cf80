#include "cli/options/vda_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "cli/parser/option_set.h"
#include "config/config_settings.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kAction = "Action";
constexpr const char* kVda = "VDA 5050";

constexpr auto kBlockingTypes = std::to_array<std::string_view>({"NONE", "SOFT", "HARD"});

// -P beside a typed option of the same name would send the parameter twice.
Status AddAssignments(const std::vector<std::string>& assignments,
                      std::vector<vda5050::Parameter>& parameters) {
  for (const std::string& text : assignments) {
    auto parameter = vda5050::ParseAssignment(text);
    if (!parameter) return Fail(std::move(parameter.error()));
    const bool twice = std::any_of(parameters.begin(), parameters.end(),
                                   [&](const auto& p) { return p.key == parameter->key; });
    if (twice) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("parameter '{}' is given twice", base::Printable(parameter->key)));
    }
    parameters.push_back(std::move(*parameter));
  }
  return {};
}

Status CheckUtf8(std::string_view option, std::string_view text) {
  if (base::IsUtf8(text)) return {};
  return Fail(ErrorKind::kUsage, fmt::format("{}: the text is not valid UTF-8", option));
}

}  // namespace

void DeclareVdaOptions(OptionSet& set, app::VdaOptions& o) {
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group(kVda);
  };
  add("--vda", VdaVersion(o.version), "V", "Version to speak: {}: the robot's own [auto]")
      .Variable("FLEETPUB_VDA");
  add("--interface", Text(o.interface_name), "NAME",
      "First topic level [uagv up to 2.x, vda5050 from 3.0]")
      .Variable("FLEETPUB_INTERFACE");
  add("--topic-template", Text(o.topic_template), "TEMPLATE",
      "The topic, with its placeholders in braces (see the manual)");
  add("--actions-key", OneOf(o.actions_key, config::kActionsKeys), "KEY",
      "{}: some 2.0 robots expect the latter");
  add("--header-version", Text(o.header_version), "TEXT",
      "The header's version, if not the one spoken");
  add("--header-manufacturer", Text(o.header_manufacturer), "TEXT",
      "The header's manufacturer, if not the topic's");
  add("--header-serial", Text(o.header_serial), "TEXT",
      "The header's serialNumber, if not the topic's");
}

void DeclareInstantOptions(OptionSet& set, InstantOptions& o) {
  // Without allow_extra_args(false) it would swallow the targets behind it, and others would be
  // commanded.
  set.AddOption("-P,--parameter", o.assignments,
                "Further action parameter: key=text, key:=json, key=@file, key:=@file; repeatable")
      .Type("KEY=VALUE")
      .OneValueEach()
      .Group(kAction);
  set.AddOption("--id", o.id, "The actionId [a random UUID]").Type("ID").Group(kAction);
  set.AddOption("--descriptor", o.descriptor, "Free text on the action").Group(kAction);
  ValueKind blocking_type = OneOf(o.blocking_type, kBlockingTypes);
  blocking_type.exists_in = [](std::string_view type, vda5050::Version version) {
    return type == "NONE" || !vda5050::GetFacts(version).only_blocking_type_none;
  };
  set.AddOption("--blocking-type", std::move(blocking_type), "{}; 3.0 allows NONE only [NONE]")
      .Type("TYPE")
      .Group(kAction);
  set.AddOption("--header-id", WholeNumber(o.header_id),
                "The headerId, above the topic's last [the next]")
      .Group(kAction);
}

Result<vda5050::InstantAction> BuildInstantAction(const InstantOptions& o, std::string_view type,
                                                  std::vector<vda5050::Parameter> parameters,
                                                  std::size_t targets) {
  if (auto ok = AddAssignments(o.assignments, parameters); !ok) return Fail(ok.error());
  if (auto ok = CheckUtf8("--id", o.id.value_or("")); !ok) return Fail(ok.error());
  if (auto ok = CheckUtf8("--descriptor", o.descriptor); !ok) return Fail(ok.error());
  if (o.id && o.id->empty()) {
    return Fail(ErrorKind::kUsage, "--id: an actionId must not be empty");
  }
  if (o.id && targets > 1) {
    return Fail(ErrorKind::kUsage, "--id names one action: give one target with it");
  }
  return vda5050::InstantAction{std::string(type), o.id.value_or(""), o.descriptor, o.blocking_type,
                                std::move(parameters)};
}

}  // namespace fleetpub::cli
