// A schema of somebody's own (or an OpenAPI document, when it says so), and behind a NUL a message
// for it.
#include "schema/schema.h"

#include <array>

#include "base/json.h"
#include "fuzz/fuzz.h"

using namespace fleetpub;

FUZZ(text) {
  const auto [schema_text, message] = fuzz::Cut(text, '\0');
  for (const std::string_view pointer : {"", "/components/schemas/A"}) {
    const auto schema = schema::Schema::Compile(schema_text, "fuzz", pointer);
    if (!schema) {
      fuzz::Require(!schema.error().message.empty());
      continue;
    }
    constexpr std::array<std::string_view, 3> kMessages = {"{\"a\":[1.0,\"x\",null]}", "[]",
                                                           "\"a\""};
    for (const std::string_view fixed : kMessages) {
      static_cast<void>(schema->Validate(*base::ParseJson(fixed)));
    }
    if (const auto own = base::ParseJson(message)) static_cast<void>(schema->Validate(*own));
  }
}
