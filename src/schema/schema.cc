#include "schema/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "schema/schema_loader.h"
#include "schema/spelling.h"
#include "schema/violations.h"

namespace fleetpub::schema {
namespace {

// Four files of the official repository are no JSON, each for a comma too many:
// github.com/VDA5050/VDA5050/issues/660.
std::string_view KnownBroken(std::string_view name) {
  constexpr std::array<std::string_view, 4> kTopics = {"order", "visualization", "factsheet",
                                                       "state"};
  const std::string_view file = name.substr(name.rfind('/') + 1);
  const bool known =
      std::find(kTopics.begin(), kTopics.end(), file.substr(0, file.find('.'))) != kTopics.end();
  return known ? "; as first published, order, visualization and factsheet of 3.0.0 and state of "
                 "2.0.0 are known not to be valid JSON: take a repaired edition"
               : "";
}

}  // namespace

Schema::Schema(std::unique_ptr<const CheckedSchema> checked) : checked_(std::move(checked)) {}
Schema::Schema(Schema&&) noexcept = default;
Schema& Schema::operator=(Schema&&) noexcept = default;
Schema::~Schema() = default;

Result<Schema> Schema::Compile(std::string_view text, std::string_view name,
                               std::string_view pointer) {
  auto checked = LoadSchema(text, pointer);
  if (checked) return Schema(std::move(*checked));
  const std::string& why = checked.error().message;
  return Fail(ErrorKind::kInvalid,
              fmt::format("schema {}: {}{}", base::Printable(name), why,
                          why.starts_with("not valid JSON") ? KnownBroken(name) : ""));
}

Result<Schema> Schema::Compile(const Embedded& embedded, std::string_view pointer) {
  auto checked = LoadSchema(embedded.rules, pointer, SchemaOrigin::kBuiltIn);
  if (checked) return Schema(std::move(*checked));
  return Fail(ErrorKind::kInvalid,
              fmt::format("schema {}: {}", embedded.name, checked.error().message));
}

std::vector<Violation> Schema::Validate(const base::JsonValue& message) const {
  return CollectViolations(*checked_, message);
}

std::vector<Violation> Schema::FindMisspellings(const base::JsonValue& message) const {
  return CollectMisspellings(*checked_, message);
}

}  // namespace fleetpub::schema
