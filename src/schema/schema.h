// JSON Schema validation.
//
// A schema is known by name: `vda5050/3.0.0/instantActions`. The built-in ones are embedded at
// build time; a folder of the user's own can be laid before them.
//
// Threads: a Registry belongs to one thread. A Schema may be used by several at once.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "message/finding.h"

namespace fleetpub::schema {

using message::Violation;

struct CheckedSchema;
struct Embedded;

/// A compiled schema: JSON Schema draft-07, with `date-time` asserted (RFC 3339, real calendar) and
/// every other `format` an annotation. `pattern` is matched by RE2 in linear time. A schema that
/// names draft-06, 2019-09 or 2020-12 in `$schema` is taken as well when it uses nothing that
/// draft-07 does not have, and so is a part of an OpenAPI 3.0 document (schema/openapi.h).
class Schema {
 public:
  /// Compiles. A schema that is no valid schema, uses a keyword that we do not check, refers to
  /// something that is not in it or only to itself, or would hang or crash a validator is refused:
  /// ErrorKind::kInvalid, with the JSON Pointer of the place. `name` is for messages. `pointer`
  /// leads to the schema when it is only a part of the text: `/components/schemas/MESSAGE`.
  [[nodiscard]] static Result<Schema> Compile(std::string_view text, std::string_view name,
                                              std::string_view pointer = {});
  [[nodiscard]] static Result<Schema> Compile(const Embedded& embedded,
                                              std::string_view pointer = {});

  Schema(Schema&&) noexcept;
  Schema& operator=(Schema&&) noexcept;
  ~Schema();

  /// Every violation, in the order of the message; empty when valid. Only causes are listed, not
  /// the objects around them; after kMostViolations one line says that there are more. `message`
  /// comes from base::ParseJson, which bounds its depth.
  [[nodiscard]] std::vector<Violation> Validate(const base::JsonValue& message) const;

  /// Members that it does not know, and whose names are nearly ones that it knows (`action_id`).
  [[nodiscard]] std::vector<Violation> FindMisspellings(const base::JsonValue& message) const;

  static constexpr std::size_t kMostViolations = 1000;

 private:
  explicit Schema(std::unique_ptr<const CheckedSchema> checked);
  std::unique_ptr<const CheckedSchema> checked_;
};

/// With this a `$comment` names the keywords (and, of `required`, the members) in which ours says
/// more than the published schema: a finding of these says so.
inline constexpr std::string_view kCorrected = "Corrected: ";

/// A built-in schema as it was embedded (schema/embed.cc).
struct Embedded {
  std::string_view name;  ///< `vda5050/3.0.0/instantActions`
  std::string_view text;  ///< without line breaks; base::ToPrettyJson makes it readable
  /// The same for the validator: what describes left out, OpenAPI translated to JSON Schema.
  std::string_view rules;
};

/// All of them, sorted by name.
[[nodiscard]] std::span<const Embedded> EmbeddedSchemas();

/// Finds schemas by name and compiles each once.
class Registry {
 public:
  /// The schema files of `directory` (schema_files.h says which file holds which schema) stand
  /// before the built-in ones. An empty `directory` means built-in ones only; one that cannot be
  /// taken makes Text and Find fail with ErrorKind::kUsage.
  explicit Registry(const std::filesystem::path& directory = {});

  /// The text, for `schema show`: complete, with a copy of what it refers to in other files.
  /// Unknown name: ErrorKind::kUsage, naming what is close.
  [[nodiscard]] Result<std::string> Text(std::string_view name) const;

  /// Owned by the registry and valid as long as it lives. A part of a document is named by a
  /// pointer: `soar/1.0/messages#/components/schemas/MESSAGE`. Errors: as Text and Schema::Compile.
  [[nodiscard]] Result<const Schema*> Find(std::string_view name);

  /// Where it comes from: `built-in` or a path.
  [[nodiscard]] std::string FindOrigin(std::string_view name) const;

  /// Every name that Find accepts, sorted, with where it comes from ("built-in" or a path).
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> List() const;

 private:
  std::map<std::string, std::filesystem::path, std::less<>> files_;  // SchemaFiles
  Status scanned_;
  std::map<std::string, Schema, std::less<>> compiled_;
};

}  // namespace fleetpub::schema
