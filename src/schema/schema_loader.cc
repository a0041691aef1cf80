#include "schema/schema_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "schema/openapi.h"
#include "schema/references.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::ToView;
using rapidjson::SizeType;
using Value = base::JsonValue;
using Node = SchemaNode;

// A schema is checked in time quadratic in its size, and the largest published one has 60 KB.
constexpr base::JsonLimits kLimits = {.bytes = std::size_t{1024} * 1024};

// Of a few dozen names hardly two are of one length: then no letters are compared.
bool IsBefore(std::string_view a, std::string_view b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

// Every check says what is wrong by Refuse and returns false (or null); the first one ends the walk.
class Loader {
 public:
  explicit Loader(CheckedSchema& checked) : checked_(checked), references_(checked.document) {}

  bool Run(std::string_view pointer) {
    const Place top;
    Place root;
    root.prefix = pointer;
    const Value* schema = FollowPointer(checked_.document, pointer);
    if (schema == nullptr) return Refuse(root, "is not there");
    if (pointer.empty() && IsOpenApi(checked_.document)) {
      return Refuse(
          top,
          "is an OpenAPI document: one of its schemas must be named, with #/components/schemas/…");
    }
    return Dialect(top) && Load(*schema, root) != nullptr && References();
  }

  [[nodiscard]] Error TakeError() { return {ErrorKind::kInvalid, std::move(error_)}; }

 private:
  using Check = bool (Loader::*)(const Value&, const Place&, Node&);
  struct Keyword {
    std::string_view name;
    Check check;
    const Value* Node::*slot = nullptr;  // where the walk finds the value
  };
  static const std::array<Keyword, 57> kKeywords;

  bool Refuse(const Place& place, std::string_view what) {
    const std::string pointer = place.Pointer();
    error_ = fmt::format("{} {}", pointer.empty() ? "the schema" : base::Printable(pointer), what);
    return false;
  }

  bool MustBe(bool holds, const Place& place, std::string_view what, const Value& value) {
    return holds || Refuse(place, fmt::format("must be {}, not {}", what, Shown(value)));
  }

  // Which edition of JSON Schema. Later ones are taken: what they add is refused by its keyword.
  bool Dialect(const Place& root) {
    const Value* dialect = base::FindMember(checked_.document, "$schema");
    if (dialect == nullptr) return true;
    const Place place = root.Below("$schema");
    if (!IsText(*dialect, place)) return false;
    std::string_view uri = ToView(*dialect);
    uri.remove_prefix(uri.find("//") == std::string_view::npos ? 0 : uri.find("//") + 2);
    if (uri.ends_with('#')) uri.remove_suffix(1);
    constexpr std::string_view kSite = "json-schema.org/";
    if (uri.starts_with(kSite)) uri.remove_prefix(kSite.size());
    is_2020_ = uri == "draft/2020-12/schema";
    siblings_count_ = is_2020_ || uri == "draft/2019-09/schema";
    const bool plain = uri == "draft-07/schema" || uri == "draft-06/schema" || uri == "schema";
    return MustBe(plain || siblings_count_, place, "draft-07", *dialect);
  }

  // Null when it is refused.
  Node* Load(const Value& schema, const Place& place) {
    const auto [known, is_new] = nodes_.emplace(&schema, nullptr);
    if (!is_new) return known->second;
    Node& node = checked_.nodes.emplace_back();
    known->second = &node;
    node.source = &schema;
    node.is_false = schema.IsFalse();
    if (schema.IsBool()) return &node;
    const bool is_schema =
        MustBe(schema.IsObject(), place, "a schema (an object, true or false)", schema);
    return is_schema && Keywords(schema, place, node) ? &node : nullptr;
  }

  bool Keywords(const Value& schema, const Place& place, Node& node) {
    const Value* reference = base::FindMember(schema, "$ref");
    const bool only_reference = reference != nullptr && !siblings_count_;
    Place here = place;
    if (!only_reference && !Identify(schema, here)) return false;
    if (reference != nullptr && !Reference(node, *reference, here)) return false;
    for (const auto& member : schema.GetObject()) {
      const std::string_view name = ToView(member.name);
      if (only_reference && name != "definitions" && name != "$defs") continue;
      const Keyword* keyword = FindKeyword(name);
      if (keyword == nullptr) continue;
      if (keyword->slot != nullptr) node.*keyword->slot = &member.value;
      if (!(this->*keyword->check)(member.value, here.Below(name), node)) return false;
    }
    return true;
  }

  // Null when it is unknown: JSON Schema has such ones ignored (§6.5).
  static const Keyword* FindKeyword(std::string_view name) {
    const auto* keyword =
        std::lower_bound(kKeywords.begin(), kKeywords.end(), name,
                         [](const Keyword& k, std::string_view n) { return k.name < n; });
    return keyword != kKeywords.end() && keyword->name == name ? keyword : nullptr;
  }

  bool Identify(const Value& schema, Place& here) {
    const Value* id = base::FindMember(schema, "$id");
    if (id == nullptr) return true;
    const Place place = here.Below("$id");
    return IsText(*id, place) && (references_.Identify(schema, ToView(*id), here) ||
                                  Refuse(place, "stands there for a second schema"));
  }

  bool Reference(Node& node, const Value& reference, const Place& here) {
    const Place place = here.Below("$ref");
    if (!IsText(reference, place)) return false;
    references_.Add(node, ToView(reference), place);
    return true;
  }

  // Resolving can find schemas in places that are none by draft-07 (`#/components/x`), and these
  // more references.
  bool References() {
    for (std::size_t i = 0; i < references_.size(); ++i) {
      const auto found = references_.Resolve(i);
      if (!found) return error_ = found.error(), false;
      Place place;
      place.prefix = found->pointer;
      place.base = found->base;
      found->from->reference = Load(*found->schema, place);
      if (found->from->reference == nullptr) return false;
    }
    const auto chains = references_.CheckChains(checked_.nodes);
    return chains.has_value() || (error_ = chains.error(), false);
  }

  bool IsText(const Value& value, const Place& place) {
    return MustBe(value.IsString(), place, "a string", value);
  }

  // --- what a keyword's value must be

  bool Anything(const Value& /*value*/, const Place& /*place*/, Node& /*node*/) { return true; }

  // It constrains in another edition of JSON Schema; to pass over it would be to check half of a
  // message.
  bool Unchecked(const Value& /*value*/, const Place& place, Node& /*node*/) {
    return Refuse(place, "is a keyword that draft-07 does not have and that would not be checked");
  }

  bool Text(const Value& value, const Place& place, Node& /*node*/) { return IsText(value, place); }

  bool Format(const Value& value, const Place& place, Node& node) {
    if (!IsText(value, place)) return false;
    node.is_date_time = ToView(value) == "date-time";  // others: annotations (draft-07 §7.2)
    return true;
  }

  bool Flag(const Value& value, const Place& place, Node& /*node*/) {
    return MustBe(value.IsBool(), place, "true or false", value);
  }

  bool Number(const Value& value, const Place& place, Node& /*node*/) {
    return MustBe(value.IsNumber(), place, "a number", value);
  }

  bool Divisor(const Value& value, const Place& place, Node& /*node*/) {
    return MustBe(value.IsNumber() && value.GetDouble() > 0, place, "a number above 0", value);
  }

  bool Count(const Value& value, const Place& place, Node& /*node*/) {
    return MustBe(IsInteger(value) && value.GetDouble() >= 0, place, "an integer from 0 on", value);
  }

  bool List(const Value& value, const Place& place, Node& /*node*/) {
    return MustBe(value.IsArray(), place, "an array", value);
  }

  bool Unique(const Value& value, const Place& place, Node& node) {
    node.unique_items = value.IsTrue();
    return Flag(value, place, node);
  }

  bool Names(const Value& value, const Place& place, Node& node) {
    if (!List(value, place, node)) return false;
    for (SizeType i = 0; i < value.Size(); ++i) {
      if (!IsText(value[i], place.Below(i))) return false;
    }
    return !FirstRepeat(value) || Refuse(place, "must not name anything twice");
  }

  bool Type(const Value& value, const Place& place, unsigned& bits) {
    // Sorted, as they are listed. A boolean is of one of two types to RapidJSON.
    constexpr std::array<std::pair<std::string_view, unsigned>, 7> kTypes = {
        {{"array", 1U << rapidjson::kArrayType},
         {"boolean", 1U << rapidjson::kFalseType | 1U << rapidjson::kTrueType},
         {"integer", Node::kIntegerBit},
         {"null", 1U << rapidjson::kNullType},
         {"number", 1U << rapidjson::kNumberType},
         {"object", 1U << rapidjson::kObjectType},
         {"string", 1U << rapidjson::kStringType}}};
    for (const auto& [name, bit] : kTypes) {
      if (!value.IsString() || ToView(value) != name) continue;
      bits |= bit;
      return true;
    }
    std::vector<std::string> names;
    names.reserve(kTypes.size());
    for (const auto& [name, bit] : kTypes) names.emplace_back(name);
    return MustBe(false, place, "one of " + base::Join(names, ", "), value);
  }

  bool Types(const Value& value, const Place& place, Node& node) {
    node.types = 0;
    if (!value.IsArray()) return Type(value, place, node.types);
    if (value.Empty()) return Refuse(place, "must name at least one type");
    for (SizeType i = 0; i < value.Size(); ++i) {
      if (!Type(value[i], place.Below(i), node.types)) return false;
    }
    return !FirstRepeat(value) || Refuse(place, "must not name a type twice");
  }

  template <const Node* Node::*kSlot>
  bool Schema(const Value& value, const Place& place, Node& node) {
    return (node.*kSlot = Load(value, place)) != nullptr;
  }

  template <std::vector<const Node*> Node::*kSlot>
  bool Schemas(const Value& value, const Place& place, Node& node) {
    if (!List(value, place, node)) return false;
    if (value.Empty()) return Refuse(place, "must hold at least one schema");
    return EachSchema(value, place, node.*kSlot);
  }

  bool EachSchema(const Value& array, const Place& place, std::vector<const Node*>& nodes) {
    for (SizeType i = 0; i < array.Size(); ++i) {
      nodes.push_back(Load(array[i], place.Below(i)));
      if (nodes.back() == nullptr) return false;
    }
    return true;
  }

  bool Items(const Value& value, const Place& place, Node& node) {
    node.items_are_listed = value.IsArray() && !is_2020_;
    return node.items_are_listed ? EachSchema(value, place, node.listed_items)
                                 : Schema<&Node::items>(value, place, node);
  }

  // Calls `take` with the name and node of each.
  template <typename Take>
  bool SchemaMap(const Value& value, const Place& place, const Take& take) {
    if (!MustBe(value.IsObject(), place, "an object of schemas", value)) return false;
    for (const auto& [name, schema] : value.GetObject()) {
      const Place below = place.Below(ToView(name));
      const Node* node = Load(schema, below);
      if (node == nullptr || !take(name, below, node)) return false;
    }
    return true;
  }

  bool Definitions(const Value& value, const Place& place, Node& /*node*/) {
    return SchemaMap(value, place, [](auto&&...) { return true; });
  }

  bool Properties(const Value& value, const Place& place, Node& node) {
    const bool fine = SchemaMap(value, place, [&](const Value& name, const Place&, const Node* of) {
      return node.properties.emplace_back(ToView(name), of), true;
    });
    std::sort(node.properties.begin(), node.properties.end(),
              [](const auto& a, const auto& b) { return IsBefore(a.first, b.first); });
    return fine;
  }

  bool PatternProperties(const Value& value, const Place& place, Node& node) {
    return SchemaMap(value, place, [&](const Value& name, const Place& below, const Node* of) {
      auto pattern = Expression(name, below);
      if (pattern) node.pattern_properties.emplace_back(std::move(*pattern), of);
      return pattern.has_value();
    });
  }

  bool Dependencies(const Value& value, const Place& place, Node& node) {
    if (!MustBe(value.IsObject(), place, "an object", value)) return false;
    for (const auto& [name, needs] : value.GetObject()) {
      const Place below = place.Below(ToView(name));
      auto& dependency = node.dependencies.emplace_back(Node::Dependency{ToView(name), &needs});
      const bool fine = needs.IsArray() ? Names(needs, below, node)
                                        : (dependency.schema = Load(needs, below)) != nullptr;
      if (!fine) return false;
    }
    return true;
  }

  std::optional<Pattern> Expression(const Value& expression, const Place& place) {
    auto pattern = Pattern::Compile(ToView(expression));
    if (pattern) return std::move(*pattern);
    Refuse(place, "is a pattern that cannot be used: " + pattern.error().message);
    return std::nullopt;
  }

  bool OnePattern(const Value& value, const Place& place, Node& node) {
    return IsText(value, place) && (node.pattern = Expression(value, place)).has_value();
  }

  CheckedSchema& checked_;
  ReferenceTable references_;
  bool is_2020_ = false;
  bool siblings_count_ = false;  // beside a `$ref`: from 2019-09 on; in draft-07 not (§8.3)
  std::unordered_map<const Value*, Node*> nodes_;
  std::string error_;
};

// Sorted by name, capitals first.
const std::array<Loader::Keyword, 57> Loader::kKeywords = {{
    {"$comment", &Loader::Text},
    {"$defs", &Loader::Definitions},
    {"$dynamicRef", &Loader::Unchecked},
    {"$id", &Loader::Text},
    {"$recursiveRef", &Loader::Unchecked},
    {"$schema", &Loader::Text},
    {"additionalItems", &Loader::Schema<&Node::additional_items>},
    {"additionalProperties", &Loader::Schema<&Node::additional_properties>},
    {"allOf", &Loader::Schemas<&Node::all_of>},
    {"anyOf", &Loader::Schemas<&Node::any_of>},
    {"const", &Loader::Anything, &Node::constant},
    {"contains", &Loader::Schema<&Node::contains>},
    {"contentEncoding", &Loader::Text},
    {"contentMediaType", &Loader::Text},
    {"default", &Loader::Anything},
    {"definitions", &Loader::Definitions},
    {"dependencies", &Loader::Dependencies},
    {"dependentRequired", &Loader::Unchecked},
    {"dependentSchemas", &Loader::Unchecked},
    {"description", &Loader::Text},
    {"disallow", &Loader::Unchecked},
    {"divisibleBy", &Loader::Unchecked},
    {"else", &Loader::Schema<&Node::otherwise>},
    {"enum", &Loader::List, &Node::choice},
    {"examples", &Loader::List},
    {"exclusiveMaximum", &Loader::Number, &Node::exclusive_maximum},
    {"exclusiveMinimum", &Loader::Number, &Node::exclusive_minimum},
    {"extends", &Loader::Unchecked},
    {"format", &Loader::Format},
    {"if", &Loader::Schema<&Node::condition>},
    {"items", &Loader::Items},
    {"maxContains", &Loader::Unchecked},
    {"maxItems", &Loader::Count, &Node::max_items},
    {"maxLength", &Loader::Count, &Node::max_length},
    {"maxProperties", &Loader::Count, &Node::max_properties},
    {"maximum", &Loader::Number, &Node::maximum},
    {"minContains", &Loader::Unchecked},
    {"minItems", &Loader::Count, &Node::min_items},
    {"minLength", &Loader::Count, &Node::min_length},
    {"minProperties", &Loader::Count, &Node::min_properties},
    {"minimum", &Loader::Number, &Node::minimum},
    {"multipleOf", &Loader::Divisor, &Node::multiple_of},
    {"not", &Loader::Schema<&Node::excluded>},
    {"oneOf", &Loader::Schemas<&Node::one_of>},
    {"pattern", &Loader::OnePattern},
    {"patternProperties", &Loader::PatternProperties},
    {"prefixItems", &Loader::Unchecked},
    {"properties", &Loader::Properties},
    {"propertyNames", &Loader::Schema<&Node::property_names>},
    {"readOnly", &Loader::Flag},
    {"required", &Loader::Names, &Node::required},
    {"then", &Loader::Schema<&Node::then>},
    {"title", &Loader::Text},
    {"type", &Loader::Types},
    {"unevaluatedItems", &Loader::Unchecked},
    {"unevaluatedProperties", &Loader::Unchecked},
    {"uniqueItems", &Loader::Unique},
}};

}  // namespace

const SchemaNode* SchemaNode::FindProperty(std::string_view name) const {
  const auto it = std::lower_bound(properties.begin(), properties.end(), name,
                                   [](const auto& a, auto b) { return IsBefore(a.first, b); });
  return it != properties.end() && it->first == name ? it->second : nullptr;
}

Result<std::unique_ptr<const CheckedSchema>> LoadSchema(std::string_view text,
                                                        std::string_view pointer,
                                                        SchemaOrigin origin) {
  auto checked = std::make_unique<CheckedSchema>();
  if (origin == SchemaOrigin::kBuiltIn) {  // written by base::ToJson: nothing is to be doubted
    checked->document.Parse<rapidjson::kParseFullPrecisionFlag>(text.data(), text.size());
  } else {
    auto document = base::ParseJson(text, kLimits);
    if (!document) return Fail(std::move(document.error()));
    checked->document = std::move(*document);
    if (IsOpenApi(checked->document)) {
      auto translated = TranslateOpenApi(checked->document);
      if (!translated) return Fail(ErrorKind::kInvalid, std::move(translated.error()));
    }
  }
  Loader loader(*checked);
  if (!loader.Run(pointer)) return Fail(loader.TakeError());
  return checked;
}

}  // namespace fleetpub::schema
