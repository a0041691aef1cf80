#include "cli/options/vda_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/text.h"
#include "cli/parser/option_set.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kAction = "Action";
constexpr const char* kVda = "VDA 5050";

Result<std::string> BlockingTypeOf(const std::string& text) {
  for (const std::string_view type : {"NONE", "SOFT", "HARD"}) {
    if (base::EqualsIgnoringCase(type, text)) return std::string(type);
  }
  if (text.empty()) return text;
  return Fail(ErrorKind::kInvalid, fmt::format("--blocking-type takes NONE, SOFT or HARD, not '{}'",
                                               base::Printable(text)));
}

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
  return Fail(ErrorKind::kInvalid, fmt::format("{}: the text is not valid UTF-8", option));
}

}  // namespace

void DeclareVdaOptions(OptionSet& set, app::VdaOptions& o) {
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    return set.AddOption(names, value, help).Type(type).Group(kVda);
  };
  add("--vda", o.version, "V",
      "Version to speak: 1.1.0, 2.0.0, 2.1.0, 3.0.0, or auto: the robot's own [auto]")
      .Variable("FLEETPUB_VDA");
  add("--interface", o.interface_name, "NAME",
      "First topic level [uagv up to 2.x, vda5050 from 3.0]")
      .Variable("FLEETPUB_INTERFACE");
  add("--topic-template", o.topic_template, "TEMPLATE",
      "The topic, with its placeholders in braces (see the manual)");
  add("--actions-key", o.actions_key, "KEY",
      "actions or instantActions: some 2.0 robots expect the latter");
  add("--header-version", o.header_version, "TEXT", "The header's version, if not the one spoken");
  add("--header-manufacturer", o.header_manufacturer, "TEXT",
      "The header's manufacturer, if not the topic's");
  add("--header-serial", o.header_serial, "TEXT", "The header's serialNumber, if not the topic's");
}

void DeclareInstantOptions(OptionSet& set, InstantOptions& o) {
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    set.AddOption(names, value, help).Type(type).Group(kAction);
  };
  // Without allow_extra_args(false) it would swallow the targets behind it, and others would be
  // commanded.
  set.AddOption("-P,--parameter", o.assignments,
                "Further action parameter: key=text, key:=json, key=@file, key:=@file; repeatable")
      .Type("KEY=VALUE")
      .OneValueEach()
      .Group(kAction);
  set.AddOption("--id", o.id, "The actionId [a random UUID]").Type("ID").Group(kAction);
  add("--descriptor", o.descriptor, "TEXT", "Free text on the action");
  add("--blocking-type", o.blocking_type, "TYPE", "NONE, SOFT, HARD; 3.0 allows NONE only [NONE]");
  add("--header-id", o.header_id, "N", "The headerId, above the topic's last [the next]");
}

Result<vda5050::InstantAction> BuildInstantAction(const InstantOptions& o, std::string_view type,
                                                  std::vector<vda5050::Parameter> parameters,
                                                  std::size_t targets) {
  const auto blocking_type = BlockingTypeOf(o.blocking_type);
  if (!blocking_type) return Fail(blocking_type.error());
  if (auto ok = AddAssignments(o.assignments, parameters); !ok) return Fail(ok.error());
  if (auto ok = CheckUtf8("--id", o.id.value_or("")); !ok) return Fail(ok.error());
  if (auto ok = CheckUtf8("--descriptor", o.descriptor); !ok) return Fail(ok.error());
  if (o.id && targets > 1) {
    return Fail(ErrorKind::kUsage, "--id names one action: give one target with it");
  }
  return vda5050::InstantAction{std::string(type), o.id.value_or(""), o.descriptor, *blocking_type,
                                std::move(parameters)};
}

Result<std::optional<std::uint32_t>> HeaderIdOf(const std::string& text) {
  if (text.empty()) return std::optional<std::uint32_t>();
  std::uint32_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--header-id takes a whole number from 0 to {}, not '{}'",
                            std::numeric_limits<std::uint32_t>::max(), base::Printable(text)));
  }
  return std::optional(id);
}

}  // namespace fleetpub::cli
