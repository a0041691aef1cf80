// Is a message valid, yes or no: the way taken for every message, with valijson.
#pragma once

#include <memory>

#include "base/rapidjson.h"
#include "schema/vet.h"

namespace fleetpub::schema {

/// How often schemas that are referred to may be applied to one message. Only references let the
/// work grow beyond schema times message, and then exponentially.
constexpr int kMostWork = 10'000'000;

/// Thrown beyond kMostWork.
struct TooMuchWork {};

class Validator {
 public:
  /// `vetted` outlives the validator.
  explicit Validator(const Vetted& vetted);
  ~Validator();

  /// May be called by several threads at once. Throws TooMuchWork.
  [[nodiscard]] bool IsValid(const base::JsonValue& message) const;

 private:
  class Rules;
  std::unique_ptr<const Rules> rules_;
};

}  // namespace fleetpub::schema
