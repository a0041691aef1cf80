#include "simulator/inspection.h"

#include <fmt/format.h>

#include <charconv>

#include "base/json.h"
#include "base/text.h"
#include "delivery/validate.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/rules/text_rules.h"

namespace fleetpub::simulator {
namespace {

using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;

std::string FormatHeaderId(const Value& message) {
  const Value* id = FindMember(message, "headerId");
  return id != nullptr && id->IsUint64() ? fmt::format("{}", id->GetUint64()) : std::string();
}

std::vector<Parameter> ReadParameters(const Value& action) {
  std::vector<Parameter> parameters;
  const Value* array = FindMember(action, "actionParameters");
  if (array == nullptr || !array->IsArray()) return parameters;
  for (const Value& item : array->GetArray()) {
    const Value* value = FindMember(item, "value");
    if (value == nullptr) continue;
    std::string key(StringMember(item, "key"));
    if (value->IsString()) {
      parameters.push_back({std::move(key), std::string(base::ToView(*value))});
    } else if (value->IsNumber()) {
      parameters.push_back({std::move(key), value->GetDouble()});
    }
  }
  return parameters;
}

ReceivedAction ReadAction(const Value& action, vda5050::Version version) {
  ReceivedAction received;
  received.call.id = StringMember(action, "actionId");
  received.call.type = StringMember(action, "actionType");
  received.call.parameters = ReadParameters(action);
  received.descriptor = StringMember(action, vda5050::GetFacts(version).descriptor_key);
  const auto* spec = vda5050::FindAction(version, received.call.type);
  if (spec == nullptr || !spec->scopes.instant) {
    received.fault = fmt::format("{} is no instant action that this robot knows",
                                 base::Printable(received.call.type));
  }
  return received;
}

// Of `/actions/3/actionId` it is 3.
std::optional<std::size_t> ActionIndex(std::string_view path) {
  const auto slash = path.find('/', 1);
  if (slash == std::string_view::npos) return std::nullopt;
  std::size_t index = 0;
  const auto [end, error] =
      std::from_chars(path.data() + slash + 1, path.data() + path.size(), index);
  return error == std::errc() ? std::optional(index) : std::nullopt;
}

void Blame(Inspection& inspection, const schema::Violation& violation) {
  const auto index = ActionIndex(violation.path);
  if (!index || *index >= inspection.actions.size()) {
    inspection.fault = violation.message;
    return;
  }
  std::string& fault = inspection.actions[*index].fault;
  if (fault.empty()) fault = violation.message;
}

}  // namespace

std::string Inspection::Place(std::string_view topic) const {
  return header_id.empty() ? std::string(topic) : fmt::format("{} headerId {}", topic, header_id);
}

Inspection Inspector::Open(std::string_view payload, std::string_view topic) {
  Inspection inspection;
  auto message = base::ParseJson(payload);
  if (!message) {
    inspection.fault = message.error().message;
    return inspection;
  }
  inspection.message = std::move(*message);
  inspection.header_id = FormatHeaderId(inspection.message);
  const auto& facts = vda5050::GetFacts(settings_.version);
  if (!settings_.actions_key.empty()) {
    base::RenameMember(inspection.message, settings_.actions_key, facts.actions_key);
  }
  const auto schema = registry_.Find(fmt::format("vda5050/{}/{}", facts.name, topic));
  if (schema) {
    inspection.fault = delivery::Describe(delivery::Check(inspection.message, **schema, {}));
  }
  const std::string_view version = StringMember(inspection.message, "version");
  if (inspection.fault.empty() &&
      vda5050::VersionSpoken(version, "") != vda5050::SpokenVersion{settings_.version, true}) {
    inspection.fault = fmt::format("the header's version is \"{}\", this robot speaks {}",
                                   base::Printable(version), facts.name);
  }
  return inspection;
}

Inspection Inspector::InspectInstantActions(std::string_view payload) {
  Inspection inspection = Open(payload, "instantActions");
  const Value* actions =
      FindMember(inspection.message, vda5050::GetFacts(settings_.version).actions_key);
  if (actions != nullptr && actions->IsArray()) {
    for (const Value& action : actions->GetArray()) {
      inspection.actions.push_back(ReadAction(action, settings_.version));
    }
  }
  if (!inspection.fault.empty()) return inspection;
  for (const auto& finding : CheckInstantActions(inspection.message, settings_.version)) {
    if (finding.is_error) Blame(inspection, finding.violation);
  }
  return inspection;
}

Inspection Inspector::Inspect(std::string_view topic, std::string_view payload) {
  Inspection inspection = Open(payload, topic);
  const auto rules = vda5050::TextRulesFor(topic, settings_.version);
  if (!inspection.fault.empty() || !rules) return inspection;
  for (const auto& finding : rules(inspection.message)) {
    if (finding.is_error && inspection.fault.empty()) inspection.fault = finding.violation.message;
  }
  return inspection;
}

}  // namespace fleetpub::simulator
