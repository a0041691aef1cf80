// `$id` and `$ref` of one schema document: what is called how, and which schema a reference means.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <unordered_map>

#include "base/rapidjson.h"

namespace fleetpub::schema {

struct SchemaNode;

/// Where a walk through a schema stands. A link of a chain on the stack: `up` outlives it.
struct Place {
  const Place* up = nullptr;
  std::string_view name = {};    ///< of a member, when data() is not null
  std::size_t index = 0;         ///< of an array's item, else
  std::string_view prefix = {};  ///< with no `up`: a pointer to begin with
  std::string_view base = {};    ///< URI of the innermost `$id`; outlives the walk

  [[nodiscard]] Place Below(std::string_view member) const { return {this, member, 0, {}, base}; }
  [[nodiscard]] Place Below(std::size_t item) const { return {this, {}, item, {}, base}; }
  [[nodiscard]] std::string Pointer() const;
};

/// The value that a JSON Pointer leads to (RFC 6901 §4), or null; also when it is no pointer.
[[nodiscard]] const base::JsonValue* FollowPointer(const base::JsonValue& document,
                                                   std::string_view pointer);

class ReferenceTable {
 public:
  template <typename T>
  using Checked = tl::expected<T, std::string>;  // the error begins with the pointer of the place

  struct Found {
    SchemaNode* from;
    const base::JsonValue* schema;
    std::string_view pointer;  ///< the fragment, for messages
    std::string_view base;
  };

  /// `document` outlives the table.
  explicit ReferenceTable(const base::JsonValue& document) { documents_.emplace("", &document); }

  /// `schema` at `here` is called `id`; `here.base` becomes its URI. False when the name is taken.
  bool Identify(const base::JsonValue& schema, std::string_view id, Place& here);

  void Add(SchemaNode& from, std::string_view reference, const Place& place);
  [[nodiscard]] std::size_t size() const { return references_.size(); }

  /// The schema that the reference means, once every `$id` is known.
  Checked<Found> Resolve(std::size_t index);

  /// That no schema asks for itself without a step into the message, and none asks so through too
  /// many others: the walk would exhaust the stack. `schemas` are all, their references followed.
  [[nodiscard]] Checked<void> CheckChains(const std::deque<SchemaNode>& schemas) const;

 private:
  struct Reference {
    SchemaNode* from;
    std::string text;      // as it stands there, for messages
    std::string uri;       // resolved, without the fragment
    std::string fragment;  // decoded
    std::string place;
  };
  using Named = std::unordered_map<std::string, const base::JsonValue*>;

  [[nodiscard]] const base::JsonValue* Find(const Reference& reference) const;

  Named documents_;  // by URI without a fragment
  Named anchors_;    // by URI with a fragment that is a name
  std::deque<Reference> references_;
};

}  // namespace fleetpub::schema
