#include "cli/message_validator.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "base/text.h"
#include "base/time.h"
#include "schema/schema_files.h"
#include "soar/message.h"
#include "soar/text_rules.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::cli {
namespace {

using delivery::Findings;

// A message's topic, told from a member that only this topic has, or has first in this order: a
// position can stand in a state as well.
struct Mark {
  std::string_view member;
  std::string_view topic;
};
constexpr std::array<Mark, 19> kMarks = {{
    {"actions", "instantActions"},
    {"instantActions", "instantActions"},
    {"connectionState", "connection"},
    {"nodes", "order"},
    {"edges", "order"},
    {"nodeStates", "state"},
    {"edgeStates", "state"},
    {"actionStates", "state"},
    {"operatingMode", "state"},
    {"typeSpecification", "factsheet"},
    {"physicalParameters", "factsheet"},
    {"protocolLimits", "factsheet"},
    {"protocolFeatures", "factsheet"},
    {"responses", "responses"},
    {"zoneSet", "zoneSet"},
    {"referenceStateHeaderId", "visualization"},
    {"agvPosition", "visualization"},
    {"mobileRobotPosition", "visualization"},
    {"velocity", "visualization"},
}};

Findings OneError(std::string message) { return {{{"", std::move(message)}}, {}}; }

// What a header must have, where it is still to come.
void AddHeader(vda5050::Version version, base::JsonDocument& message) {
  auto& pool = message.GetAllocator();
  const auto add = [&](const char* name, base::JsonValue value) {
    if (base::FindMember(message, name) != nullptr) return;
    message.AddMember(base::JsonValue(name, pool), value, pool);
  };
  const auto text = [&](std::string_view t) {
    return base::JsonValue(t.data(), static_cast<rapidjson::SizeType>(t.size()), pool);
  };
  if (!message.IsObject()) return;
  add("headerId", base::JsonValue(0));
  add("timestamp", text(base::FormatTimestamp(base::WallTime::clock::now())));
  add("version", text(vda5050::GetFacts(version).name));
  add("manufacturer", text("m"));
  add("serialNumber", text("s"));
}

}  // namespace

Status MessageValidator::Prepare() {
  if (options_.body && (options_.is_soar || !options_.schema_file.empty())) {
    return Fail(ErrorKind::kUsage,
                "--body is for VDA 5050: a SoAR payload is checked alone with --message-type");
  }
  if (!options_.schema_file.empty()) return LoadFile();
  if (auto right = CheckCombinations(); !right || options_.is_soar) return right;
  if (!options_.version.empty()) {
    const auto version = vda5050::ParseVersion(options_.version);
    if (!version) return Fail(version.error());
    version_ = *version;
  }
  if (version_ && !options_.topic.empty()) {
    const auto schema = registry_.Find(
        fmt::format("vda5050/{}/{}", vda5050::GetFacts(*version_).name, options_.topic));
    if (!schema) return Fail(schema.error());
  }
  return {};
}

Findings MessageValidator::Check(std::string_view text) {
  auto message = base::ParseJson(text);
  if (!message) return OneError(message.error().message);
  if (own_schema_) return delivery::Check(*message, *own_schema_, {});
  if (options_.is_soar) {
    Findings findings = CheckSoar(*message);
    if (options_.strict) delivery::Harden(findings);
    return findings;
  }
  std::string chosen;
  const auto version = FindVersion(*message, chosen);
  if (!version) return OneError(version.error().message);
  const auto topic = FindTopic(*message);
  if (!topic) return OneError(topic.error().message);
  if (options_.body) AddHeader(*version, *message);
  std::vector<schema::Violation> header;
  if (!chosen.empty()) header.push_back({"/version", std::move(chosen)});
  return vda5050::CheckMessage(*message, *version, *topic, options_.strict, registry_,
                               std::move(header));
}

Status MessageValidator::CheckCombinations() const {
  if (!options_.is_soar && options_.message_type) {
    return Fail(ErrorKind::kUsage, "--message-type needs --protocol soar");
  }
  if (options_.is_soar && !options_.topic.empty()) {
    return Fail(ErrorKind::kUsage, "--topic is for VDA 5050: name a --message-type");
  }
  return {};
}

// A whole message; when a type was named, of that type, or a payload of it alone.
Findings MessageValidator::CheckSoar(const base::JsonValue& message) {
  const auto& type = options_.message_type;
  const bool whole = !type || base::FindMember(message, "payload") != nullptr;
  const auto schema =
      registry_.Find(whole ? std::string(soar::kMessageSchema) : soar::PayloadSchema(*type));
  if (!schema) return OneError(schema.error().message);
  const auto strictness = options_.strict ? soar::Strictness::kRefuse : soar::Strictness::kWarn;
  Findings findings = delivery::Check(message, **schema, [strictness](const auto& checked) {
    return soar::CheckMessage(checked, strictness);
  });
  if (!findings.satisfies_schema || !type) return findings;
  const auto& payload = whole ? *base::FindMember(message, "payload") : message;
  const std::string_view found = base::StringMember(payload, "message_type");
  if (found != GetName(*type)) {
    findings.errors.push_back(
        {whole ? "/payload/message_type" : "/message_type",
         fmt::format("is {}, not {}", base::Printable(found), GetName(*type))});
  }
  return findings;
}

Status MessageValidator::LoadFile() {
  const auto text =
      schema::ReadSchemaFile(options_.schema_file, schema::FilesBeside(options_.schema_file));
  if (!text) return Fail(text.error());
  auto schema = schema::Schema::Compile(*text, options_.schema_file);
  if (!schema) return Fail(std::move(schema.error()));
  own_schema_ = std::move(*schema);
  return {};
}

// `chosen` tells of a header that names no release.
Result<vda5050::Version> MessageValidator::FindVersion(const base::JsonValue& message,
                                                       std::string& chosen) const {
  if (version_) return *version_;
  if (const auto said = vda5050::VersionSaidBy(message)) {
    if (!said->is_release) {
      chosen = vda5050::NoReleaseText(base::StringMember(message, "version"), said->version);
    }
    return said->version;
  }
  return Fail(ErrorKind::kInvalid,
              "its header does not say which VDA 5050 version it is: name it with --vda");
}

Result<std::string> MessageValidator::FindTopic(const base::JsonValue& message) const {
  if (!options_.topic.empty()) return options_.topic;
  for (const auto& [member, topic] : kMarks) {
    if (base::FindMember(message, member) != nullptr) return std::string(topic);
  }
  return Fail(ErrorKind::kInvalid, "its content does not tell its topic: name it with --topic");
}

}  // namespace fleetpub::cli
