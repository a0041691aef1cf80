// A schema looked over before it meets a message, so that nothing in it can be misunderstood,
// half-checked, crash or hang: every keyword is one that we check, or one that constrains nothing,
// and has a value of the form that draft-07 asks for; every reference leads to a schema in the same
// document, and none only to itself.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "schema/pattern.h"

namespace fleetpub::schema {

/// One schema with its keywords by name; null or empty: not there. Those that only together mean
/// something (`then` without `if`) stand as they are written.
struct SchemaNode {
  using Value = base::JsonValue;
  struct Dependency {
    std::string_view name;
    const Value* names = nullptr;  ///< else a schema
    const SchemaNode* schema = nullptr;
  };

  const Value* source = nullptr;          ///< an object, true or false
  const SchemaNode* reference = nullptr;  ///< what `$ref` means
  bool is_false = false;

  unsigned types = ~0U;  ///< bits of 1 << rapidjson::Type, and kIntegerBit
  const Value* choice = nullptr;
  const Value* constant = nullptr;

  const Value* minimum = nullptr;
  const Value* maximum = nullptr;
  const Value* exclusive_minimum = nullptr;
  const Value* exclusive_maximum = nullptr;
  const Value* multiple_of = nullptr;

  const Value* min_length = nullptr;
  const Value* max_length = nullptr;
  bool is_date_time = false;
  std::optional<Pattern> pattern;

  const Value* min_items = nullptr;
  const Value* max_items = nullptr;
  bool unique_items = false;
  const SchemaNode* contains = nullptr;
  const SchemaNode* items = nullptr;
  bool items_are_listed = false;  ///< `items` is an array: of these
  std::vector<const SchemaNode*> listed_items;
  const SchemaNode* additional_items = nullptr;

  const Value* min_properties = nullptr;
  const Value* max_properties = nullptr;
  const Value* required = nullptr;
  std::vector<std::pair<std::string_view, const SchemaNode*>>
      properties;  ///< sorted, shorter names first
  std::vector<std::pair<Pattern, const SchemaNode*>> pattern_properties;
  const SchemaNode* additional_properties = nullptr;
  const SchemaNode* property_names = nullptr;
  std::vector<Dependency> dependencies;

  std::vector<const SchemaNode*> all_of;
  std::vector<const SchemaNode*> any_of;
  std::vector<const SchemaNode*> one_of;
  const SchemaNode* excluded = nullptr;  ///< `not`
  const SchemaNode* condition = nullptr;
  const SchemaNode* then = nullptr;
  const SchemaNode* otherwise = nullptr;

  static constexpr unsigned kIntegerBit = 1U << 7U;

  /// The schema under `properties`, or null.
  [[nodiscard]] const SchemaNode* FindProperty(std::string_view name) const;
};

/// A schema that passed, and all those that it consists of.
struct CheckedSchema {
  base::JsonDocument document;  ///< the nodes point into it, so it stays where it is
  std::deque<SchemaNode> nodes;

  [[nodiscard]] const SchemaNode& root() const { return nodes.front(); }
};

enum class SchemaOrigin {
  kUser,
  kBuiltIn,  ///< Embedded::rules: valid JSON, and OpenAPI is translated already
};

/// `pointer` leads to the schema when it is only a part of the document. Errors:
/// ErrorKind::kInvalid with the JSON Pointer of the place and what is wrong with it.
[[nodiscard]] Result<std::unique_ptr<const CheckedSchema>> LoadSchema(
    std::string_view text, std::string_view pointer = {},
    SchemaOrigin origin = SchemaOrigin::kUser);

}  // namespace fleetpub::schema
