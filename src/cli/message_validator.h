// Messages against the built-in schemas or a given one, and against the rules of the text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/json.h"
#include "base/result.h"
#include "delivery/validate.h"
#include "schema/schema.h"
#include "soar/message_type.h"
#include "vda5050/model/version.h"

namespace fleetpub::cli {

struct ValidatorOptions {
  std::string version;      ///< empty: what the header says
  std::string topic;        ///< empty: told from the message
  std::string schema_file;  ///< instead of the built-in ones
  bool is_soar = false;
  std::optional<soar::MessageType> message_type;
  bool strict = false;
  bool body = false;  ///< what a header lacks is still to come
};

/// Validates message after message; each schema is compiled once.
class MessageValidator {
 public:
  MessageValidator(const ValidatorOptions& options, const std::string& schema_directory)
      : options_(options), registry_(schema_directory) {}

  /// Once. Errors: the options or the schema, not a message.
  [[nodiscard]] Status Prepare();
  [[nodiscard]] delivery::Findings Check(std::string_view text);

 private:
  [[nodiscard]] Status CheckCombinations() const;
  [[nodiscard]] delivery::Findings CheckSoar(const base::JsonValue& message);
  [[nodiscard]] Status LoadFile();
  [[nodiscard]] Result<vda5050::Version> FindVersion(const base::JsonValue& message,
                                                     std::string& chosen) const;
  [[nodiscard]] Result<std::string> FindTopic(const base::JsonValue& message) const;

  const ValidatorOptions& options_;
  schema::Registry registry_;
  std::optional<vda5050::Version> version_;
  std::optional<schema::Schema> own_schema_;
};

}  // namespace fleetpub::cli
