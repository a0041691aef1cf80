#include "ledger/stored_actions.h"

#include "base/json.h"

namespace fleetpub::ledger {

std::string ActionsToJson(const std::vector<ActionRef>& actions) {
  std::string json = "[";
  for (const ActionRef& action : actions) {
    if (json.size() > 1) json += ',';
    json += "{\"type\":" + base::JsonString(action.type) +
            ",\"id\":" + base::JsonString(action.id) + "}";
  }
  return json + "]";
}

Result<std::vector<ActionRef>> ActionsFromJson(const std::string& text, std::int64_t row) {
  const Result<base::JsonDocument> document = base::ParseJson(text);
  if (!document) {
    return Fail(ErrorKind::kLedger,
                "the ledger's row " + std::to_string(row) + " is damaged: its actions",
                document.error().message);
  }
  std::vector<ActionRef> actions;
  if (!document->IsArray()) return actions;
  for (const base::JsonValue& action : document->GetArray()) {
    actions.push_back({std::string(base::StringMember(action, "type")),
                       std::string(base::StringMember(action, "id"))});
  }
  return actions;
}

}  // namespace fleetpub::ledger
