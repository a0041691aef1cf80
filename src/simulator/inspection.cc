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

// Whatever stands at `/nodes/2/actions/0…`.
struct ActionPlace {
  std::string_view list;
  std::size_t leg;
  std::size_t action;
};

std::optional<ActionPlace> ReadActionPlace(std::string_view path) {
  const auto parts = base::Split(path, '/');
  if (parts.size() < 5 || parts[3] != "actions") return std::nullopt;
  ActionPlace place{parts[1] == "nodes" ? "nodes" : "edges", 0, 0};
  for (const auto& [text, into] : {std::pair(parts[2], &place.leg), {parts[4], &place.action}}) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *into);
    if (error != std::errc()) return std::nullopt;
  }
  return place;
}

ReceivedAction ReadOrderAction(const Value& action, vda5050::Version version) {
  ReceivedAction received;
  received.call.id = StringMember(action, "actionId");
  received.call.type = StringMember(action, "actionType");
  if (vda5050::FindAction(version, received.call.type) == nullptr) {
    received.fault =
        fmt::format("{} is no action that this robot knows", base::Printable(received.call.type));
  }
  return received;
}

// The actions of an order as they are read, and what the rules find wrong with them.
class OrderActions {
 public:
  OrderActions(const Value& message, vda5050::Version version) {
    for (const std::string_view list : {"nodes", "edges"}) {
      const Value* legs = base::FindArray(message, list);
      for (rapidjson::SizeType i = 0; legs != nullptr && i < legs->Size(); ++i) {
        const Value* actions = base::FindArray((*legs)[i], "actions");
        for (rapidjson::SizeType k = 0; actions != nullptr && k < actions->Size(); ++k) {
          places_.push_back({list, i, k});
          actions_.push_back(ReadOrderAction((*actions)[k], version));
        }
      }
    }
  }

  /// False when it is not about an action.
  bool Blame(const schema::Violation& violation) {
    const auto place = ReadActionPlace(violation.path);
    if (!place) return false;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const ActionPlace& one = places_[i];
      if (one.list != place->list || one.leg != place->leg || one.action != place->action) continue;
      if (actions_[i].fault.empty()) actions_[i].fault = violation.message;
      return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<ReceivedAction> Take() && { return std::move(actions_); }

 private:
  std::vector<ActionPlace> places_;
  std::vector<ReceivedAction> actions_;
};

}  // namespace

std::vector<Parameter> ReadParameters(const Value& action) {
  std::vector<Parameter> parameters;
  const Value* array = FindMember(action, "actionParameters");
  if (array == nullptr || !array->IsArray()) return parameters;
  for (const Value& item : array->GetArray()) {
    const Value* value = FindMember(item, "value");
    if (value == nullptr) continue;
    std::string key(StringMember(item, "key"));
    if (value->IsArray()) {
      std::vector<std::string> texts;
      for (const Value& text : value->GetArray()) {
        if (text.IsString()) texts.emplace_back(base::ToView(text));
      }
      parameters.push_back({std::move(key), base::Join(texts, ",")});
    } else if (value->IsString()) {
      parameters.push_back({std::move(key), std::string(base::ToView(*value))});
    } else if (value->IsNumber()) {
      parameters.push_back({std::move(key), value->GetDouble()});
    }
  }
  return parameters;
}

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

Inspection Inspector::InspectOrder(std::string_view payload) {
  Inspection inspection = Open(payload, "order");
  if (!inspection.fault.empty()) return inspection;
  OrderActions actions(inspection.message, settings_.version);
  for (const auto& finding : CheckOrder(inspection.message, settings_.version)) {
    const std::string_view path = finding.violation.path;
    const bool is_passed_over =
        (settings_.Has(Fault::kTakeBaseBehindHorizon) && path.ends_with("/released")) ||
        (settings_.Has(Fault::kTakeSequenceGaps) && path.ends_with("/sequenceId"));
    if (!finding.is_error || is_passed_over || actions.Blame(finding.violation)) continue;
    if (inspection.fault.empty()) inspection.fault = finding.violation.message;
  }
  inspection.actions = std::move(actions).Take();
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
