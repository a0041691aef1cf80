// A message of VDA 5050: a line with its topic, then the JSON. Schema and text rules of its
// version.
#include "base/json.h"
#include "fuzz/fuzz.h"
#include "vda5050/rules/conformance.h"

using namespace fleetpub;

FUZZ(text) {
  static schema::Registry registry;
  static vda5050::Conformance conformance({}, registry);
  const auto [topic, payload] = fuzz::Cut(text, '\n');
  static_cast<void>(conformance.Validate(topic, payload));
  const auto document = base::ParseJson(payload);
  if (!document) return;
  const std::string printed = base::ToJson(*document);
  const auto again = base::ParseJson(printed);
  fuzz::Require(again.has_value() && base::ToJson(*again) == printed);
}
