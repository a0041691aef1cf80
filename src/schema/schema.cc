#include "schema/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "schema/explain.h"
#include "schema/validator.h"
#include "schema/vet.h"

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

struct Schema::Compiled {
  explicit Compiled(std::unique_ptr<const Vetted> schema)
      : vetted(std::move(schema)), validator(*vetted) {}

  std::unique_ptr<const Vetted> vetted;
  Validator validator;
};

Schema::Schema(std::unique_ptr<const Compiled> compiled) : compiled_(std::move(compiled)) {}
Schema::Schema(Schema&&) noexcept = default;
Schema& Schema::operator=(Schema&&) noexcept = default;
Schema::~Schema() = default;

Result<Schema> Schema::Compile(std::string_view text, std::string_view name,
                               std::string_view pointer) {
  const auto refuse = [name](std::string_view why, std::string detail = {}) {
    return Fail(ErrorKind::kInvalid, fmt::format("schema {}: {}", base::Printable(name), why),
                std::move(detail));
  };
  auto vetted = Vet(text, pointer);
  if (!vetted) {
    const std::string& why = vetted.error().message;
    return refuse(why + std::string(why.starts_with("not valid JSON") ? KnownBroken(name) : ""));
  }
  try {
    return Schema(std::make_unique<const Compiled>(std::move(*vetted)));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {  // valijson's and rapidjson's
    return refuse("it asks for more than this validator can do", e.what());
  }
}

std::vector<Violation> Schema::Validate(const base::JsonValue& message) const {
  try {
    if (compiled_->validator.IsValid(message)) return {};
    std::vector<Violation> violations = Explain(*compiled_->vetted, message, kMostViolations);
    if (violations.empty()) violations.push_back({"", "does not satisfy the schema"});
    return violations;
  } catch (const TooMuchWork&) {
    return {{"", "could not be checked: the schema's references make this message too much work"}};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {{"", "could not be checked: the schema asks for more than this validator can do"}};
  }
}

}  // namespace fleetpub::schema
