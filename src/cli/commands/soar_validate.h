// `fleetpub validate --protocol soar`.
#pragma once

#include <array>
#include <optional>

#include "base/choice.h"
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
  SoarValidator(std::optional<soar::MessageType> type, soar::Strictness strictness)
      : type_(type), strictness_(strictness) {}

  /// A whole message; when a type was named, of that type, or a payload of it alone.
  [[nodiscard]] delivery::Findings Check(const base::JsonValue& message,
                                         schema::Registry& registry) const;

 private:
  std::optional<soar::MessageType> type_;
  soar::Strictness strictness_;
};

/// Of `--protocol`: whether it is SoAR.
inline constexpr auto kProtocols =
    std::to_array<base::Choice<bool>>({{"vda5050", false}, {"soar", true}});

}  // namespace fleetpub::cli
