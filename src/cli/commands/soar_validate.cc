#include "cli/commands/soar_validate.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/text.h"
#include "soar/message.h"

namespace fleetpub::cli {

using base::FindMember;

delivery::Findings SoarValidator::Check(const base::JsonValue& message,
                                        schema::Registry& registry) const {
  const bool whole = !type_ || FindMember(message, "payload") != nullptr;
  const auto schema =
      registry.Find(whole ? std::string(soar::kMessageSchema) : soar::PayloadSchema(*type_));
  if (!schema) return {{{"", schema.error().message}}, {}};
  auto findings =
      delivery::Check(message, **schema, [strictness = strictness_](const auto& checked) {
        return soar::CheckMessage(checked, strictness);
      });
  if (!findings.satisfies_schema || !type_) return findings;
  const auto& payload = whole ? *FindMember(message, "payload") : message;
  const std::string_view found = base::StringMember(payload, "message_type");
  if (found != GetName(*type_)) {
    findings.errors.push_back(
        {whole ? "/payload/message_type" : "/message_type",
         fmt::format("is {}, not {}", base::Printable(found), GetName(*type_))});
  }
  return findings;
}

}  // namespace fleetpub::cli
