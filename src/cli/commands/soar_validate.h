// `fleetpub validate --protocol soar`.
#pragma once

#include <optional>
#include <string>

#include "base/rapidjson.h"
#include "base/result.h"
#include "delivery/validate.h"
#include "schema/schema.h"
#include "soar/message_type.h"
#include "soar/text_rules.h"

namespace fleetpub::cli {

/// Checks SoAR messages, one after the other.
class SoarValidator {
 public:
  /// `message_type` may be empty. Errors: ErrorKind::kUsage.
  [[nodiscard]] static Result<SoarValidator> Make(const std::string& message_type,
                                                  soar::Strictness strictness);

  /// A whole message; when a type was named, of that type, or a payload of it alone.
  [[nodiscard]] delivery::Findings Check(const base::JsonValue& message,
                                         schema::Registry& registry) const;

 private:
  SoarValidator(std::optional<soar::MessageType> type, soar::Strictness strictness)
      : type_(type), strictness_(strictness) {}

  std::optional<soar::MessageType> type_;
  soar::Strictness strictness_;
};

/// `vda5050` or `soar`. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<bool> IsSoar(const std::string& protocol);

}  // namespace fleetpub::cli
