#include "schema/spelling.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "schema/violations.h"

namespace fleetpub::schema {
namespace {

using base::ToView;
using Value = base::JsonValue;
using Nodes = std::vector<const SchemaNode*>;

// The node, and all that say something of the same value, each once.
void ListNodes(const SchemaNode* node, Nodes& nodes) {
  if (node == nullptr || std::find(nodes.begin(), nodes.end(), node) != nodes.end()) return;
  nodes.push_back(node);
  ListNodes(node->reference, nodes);
  for (const Nodes* list : {&node->all_of, &node->any_of, &node->one_of}) {
    for (const SchemaNode* each : *list) ListNodes(each, nodes);
  }
  for (const SchemaNode* each : {node->condition, node->then, node->otherwise}) {
    ListNodes(each, nodes);
  }
  for (const auto& dependency : node->dependencies) ListNodes(dependency.schema, nodes);
}

// `action_parameters`: `actionparameters`.
std::string KeepLetters(std::string_view name) {
  std::string letters = base::ToLower(name);
  std::erase_if(letters, [](char c) { return c == '_' || c == '-' || c == ' '; });
  return letters;
}

std::optional<std::string> NearestTo(std::string_view name,
                                     const std::vector<std::string_view>& known) {
  const std::string letters = KeepLetters(name);
  const auto same = std::find_if(known.begin(), known.end(), [&](std::string_view other) {
    return KeepLetters(other) == letters;
  });
  return same != known.end() ? std::optional<std::string>(*same) : base::Nearest(name, known);
}

// What a schema says of a member that bears the name.
template <typename Visit>
void VisitMember(const SchemaNode& node, std::string_view name, const Visit& visit) {
  const SchemaNode* known = node.FindProperty(name);
  if (known != nullptr) visit(known);
  for (const auto& [pattern, each] : node.pattern_properties) {
    if (pattern.Matches(name)) visit(each);
  }
  // Others may be called anything.
  if (known == nullptr && node.additional_properties != nullptr &&
      node.additional_properties->source->IsObject()) {
    visit(node.additional_properties);
  }
}

class Speller {
 public:
  void Check(const Nodes& schemas, const Value& value, const Where& where) {
    if (found_.size() >= Schema::kMostViolations || !HasMembers(value)) return;
    Nodes nodes;
    for (const SchemaNode* each : schemas) ListNodes(each, nodes);
    if (value.IsObject()) Object(nodes, value, where);
    if (value.IsArray()) Array(nodes, value, where);
  }

  [[nodiscard]] std::vector<Violation> Take() { return std::move(found_); }

 private:
  static bool HasMembers(const Value& value) { return value.IsObject() || value.IsArray(); }

  void Array(const Nodes& nodes, const Value& array, const Where& where) {
    for (rapidjson::SizeType i = 0; i < array.Size(); ++i) {
      if (!HasMembers(array[i])) continue;
      Nodes below;
      for (const SchemaNode* node : nodes) {
        const bool is_listed = i < node->listed_items.size();
        below.push_back(is_listed                ? node->listed_items[i]
                        : node->items_are_listed ? node->additional_items
                                                 : node->items);
      }
      Check(below, array[i], {.up = &where, .index = i});
    }
  }

  void Object(const Nodes& nodes, const Value& object, const Where& where) {
    std::size_t index = 0;
    for (const auto& [key, value] : object.GetObject()) {
      const std::string_view name = ToView(key);
      const Where here = {.up = &where, .name = name, .index = index++};
      const bool has_members = HasMembers(value);
      bool is_known = false;
      Nodes below;
      for (const SchemaNode* node : nodes) {
        VisitMember(*node, name, [&](const SchemaNode* each) {
          is_known = true;
          if (has_members) below.push_back(each);
        });
      }
      if (!is_known) {
        Unknown(nodes, object, name, here);
      } else {
        Check(below, value, here);
      }
    }
  }

  void Unknown(const Nodes& nodes, const Value& object, std::string_view name, const Where& where) {
    std::vector<std::string_view> known;
    for (const SchemaNode* node : nodes) {
      // It is a violation already.
      if (node->additional_properties != nullptr && node->additional_properties->is_false) return;
      for (const auto& [property, schema] : node->properties) {
        if (base::FindMember(object, property) == nullptr) known.push_back(property);
      }
    }
    const auto near = NearestTo(name, known);
    if (!near || found_.size() >= Schema::kMostViolations) return;
    found_.push_back(
        {MakePointer(where), fmt::format("the member \"{}\" is not known: did you mean {}?",
                                         base::Printable(name), base::Printable(*near))});
  }

  std::vector<Violation> found_;
};

}  // namespace

std::vector<Violation> CollectMisspellings(const CheckedSchema& schema, const Value& message) {
  Speller speller;
  speller.Check({&schema.root()}, message, {});
  return speller.Take();
}

}  // namespace fleetpub::schema
