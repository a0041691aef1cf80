#include "schema/vet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "schema/openapi.h"
#include "schema/references.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::ViewOf;
using rapidjson::SizeType;
using Value = base::JsonValue;

// A schema is vetted in time quadratic in its size, and the largest published one has 60 KB.
constexpr base::JsonLimits kLimits = {.bytes = std::size_t{1024} * 1024};

// Every check says what is wrong by Refuse and returns false; the first one ends the walk.
class Vetter {
 public:
  explicit Vetter(Vetted& vetted) : vetted_(vetted), references_(vetted) {}

  bool Run(std::string_view pointer) {
    const Place top;
    Place root;
    root.prefix = pointer;
    vetted_.root = Follow(vetted_.document, pointer);
    if (vetted_.root == nullptr) return Refuse(root, "is not there");
    if (pointer.empty() && IsOpenApi(vetted_.document)) {
      return Refuse(
          top,
          "is an OpenAPI document: one of its schemas must be named, with #/components/schemas/…");
    }
    return Dialect(top) && Schema(*vetted_.root, root) && References() && Chains();
  }

  [[nodiscard]] Error TakeError() { return {ErrorKind::kInvalid, std::move(error_)}; }

 private:
  using Check = bool (Vetter::*)(const Value&, const Place&);
  struct Keyword {
    std::string_view name;
    Check check;
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
    const Value* dialect = base::FindMember(vetted_.document, "$schema");
    if (dialect == nullptr) return true;
    const Place place = root.Below("$schema");
    if (!Text(*dialect, place)) return false;
    std::string_view uri = ViewOf(*dialect);
    uri.remove_prefix(uri.find("//") == std::string_view::npos ? 0 : uri.find("//") + 2);
    if (uri.ends_with('#')) uri.remove_suffix(1);
    constexpr std::string_view kSite = "json-schema.org/";
    if (uri.starts_with(kSite)) uri.remove_prefix(kSite.size());
    is_2020_ = uri == "draft/2020-12/schema";
    vetted_.reference_has_siblings = is_2020_ || uri == "draft/2019-09/schema";
    const bool plain = uri == "draft-07/schema" || uri == "draft-06/schema" || uri == "schema";
    return MustBe(plain || vetted_.reference_has_siblings, place, "draft-07", *dialect);
  }

  bool Schema(const Value& schema, const Place& place) {
    if (!seen_.insert(&schema).second) return true;
    schemas_.push_back(&schema);
    if (schema.IsBool()) return true;
    if (!MustBe(schema.IsObject(), place, "a schema (an object, true or false)", schema)) {
      return false;
    }
    const Value* reference = base::FindMember(schema, "$ref");
    const bool only_reference = reference != nullptr && !vetted_.reference_has_siblings;
    Place here = place;
    if (!only_reference && !Identify(schema, here)) return false;
    if (reference != nullptr && !Reference(schema, *reference, here)) return false;
    for (const auto& member : schema.GetObject()) {
      const std::string_view name = ViewOf(member.name);
      if (only_reference && name != "definitions" && name != "$defs") continue;
      const Check check = CheckOf(name);
      if (check != nullptr && !(this->*check)(member.value, here.Below(name))) return false;
    }
    return true;
  }

  // Null when the keyword is unknown: JSON Schema has such ones ignored (§6.5).
  static Check CheckOf(std::string_view name) {
    const auto* keyword =
        std::lower_bound(kKeywords.begin(), kKeywords.end(), name,
                         [](const Keyword& k, std::string_view n) { return k.name < n; });
    return keyword != kKeywords.end() && keyword->name == name ? keyword->check : nullptr;
  }

  bool Identify(const Value& schema, Place& here) {
    const Value* id = base::FindMember(schema, "$id");
    if (id == nullptr) return true;
    const Place place = here.Below("$id");
    return Text(*id, place) && (references_.Identify(schema, ViewOf(*id), here) ||
                                Refuse(place, "stands there for a second schema"));
  }

  bool Reference(const Value& schema, const Value& reference, const Place& here) {
    const Place place = here.Below("$ref");
    if (!Text(reference, place)) return false;
    references_.Add(schema, ViewOf(reference), place);
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
      if (!Schema(*found->schema, place)) return false;
    }
    return true;
  }

  bool Chains() {
    if (references_.size() == 0) return true;
    const auto status = references_.CheckChains(schemas_);
    return status.has_value() || (error_ = status.error(), false);
  }

  // --- what a keyword's value must be
  // -------------------------------------------------------------------------------

  bool Anything(const Value& /*value*/, const Place& /*place*/) { return true; }

  // Its keyword constrains in another edition of JSON Schema; to pass over it would be to check
  // half of a message.
  bool Unchecked(const Value& /*value*/, const Place& place) {
    return Refuse(place, "is a keyword that draft-07 does not have and that would not be checked");
  }

  bool Text(const Value& value, const Place& place) {
    return MustBe(value.IsString(), place, "a string", value);
  }

  bool Flag(const Value& value, const Place& place) {
    return MustBe(value.IsBool(), place, "true or false", value);
  }

  bool Number(const Value& value, const Place& place) {
    return MustBe(value.IsNumber(), place, "a number", value);
  }

  bool Divisor(const Value& value, const Place& place) {
    return MustBe(value.IsNumber() && value.GetDouble() > 0, place, "a number above 0", value);
  }

  bool Count(const Value& value, const Place& place) {
    return MustBe(IsInteger(value) && value.GetDouble() >= 0, place, "an integer from 0 on", value);
  }

  bool List(const Value& value, const Place& place) {
    return MustBe(value.IsArray(), place, "an array", value);
  }

  // valijson ends a name at the first NUL.
  bool WithoutNul(const Value& name, const Place& place) {
    return ViewOf(name).find('\0') == std::string_view::npos ||
           Refuse(place, "must not contain the character U+0000");
  }

  bool Names(const Value& value, const Place& place) {
    if (!List(value, place)) return false;
    for (SizeType i = 0; i < value.Size(); ++i) {
      if (!Text(value[i], place.Below(i)) || !WithoutNul(value[i], place.Below(i))) return false;
    }
    return !FirstRepeat(value) || Refuse(place, "must not name anything twice");
  }

  bool TypeOf(const Value& value, const Place& place) {
    constexpr std::array<std::string_view, 7> kTypes = {"array",  "boolean", "integer", "null",
                                                        "number", "object",  "string"};
    const bool known =
        value.IsString() && std::find(kTypes.begin(), kTypes.end(), ViewOf(value)) != kTypes.end();
    return MustBe(known, place, fmt::format("one of {}", fmt::join(kTypes, ", ")), value);
  }

  bool Types(const Value& value, const Place& place) {
    if (!value.IsArray()) return TypeOf(value, place);
    if (value.Empty()) return Refuse(place, "must name at least one type");
    for (SizeType i = 0; i < value.Size(); ++i) {
      if (!TypeOf(value[i], place.Below(i))) return false;
    }
    return !FirstRepeat(value) || Refuse(place, "must not name a type twice");
  }

  bool Schemas(const Value& value, const Place& place) {
    if (!List(value, place)) return false;
    if (value.Empty()) return Refuse(place, "must hold at least one schema");
    return EachSchema(value, place);
  }

  bool EachSchema(const Value& array, const Place& place) {
    for (SizeType i = 0; i < array.Size(); ++i) {
      if (!Schema(array[i], place.Below(i))) return false;
    }
    return true;
  }

  bool Items(const Value& value, const Place& place) {
    return value.IsArray() && !is_2020_ ? EachSchema(value, place) : Schema(value, place);
  }

  bool SchemaMap(const Value& value, const Place& place) {
    if (!MustBe(value.IsObject(), place, "an object of schemas", value)) return false;
    for (const auto& member : value.GetObject()) {
      if (!Schema(member.value, place.Below(ViewOf(member.name)))) return false;
    }
    return true;
  }

  bool Dependencies(const Value& value, const Place& place) {
    if (!MustBe(value.IsObject(), place, "an object", value)) return false;
    for (const auto& member : value.GetObject()) {
      const Place below = place.Below(ViewOf(member.name));
      if (!WithoutNul(member.name, below)) return false;
      const bool names = member.value.IsArray();
      if (!(names ? Names(member.value, below) : Schema(member.value, below))) return false;
    }
    return true;
  }

  bool Expression(const Value& expression, const Place& place) {
    auto pattern = Pattern::Compile(ViewOf(expression));
    if (!pattern) {
      return Refuse(place, "is a pattern that cannot be used: " + pattern.error().message);
    }
    vetted_.patterns.emplace(&expression, std::move(*pattern));
    return true;
  }

  bool OnePattern(const Value& value, const Place& place) {
    return Text(value, place) && Expression(value, place);
  }

  bool PatternMap(const Value& value, const Place& place) {
    if (!SchemaMap(value, place)) return false;
    for (const auto& member : value.GetObject()) {
      if (!Expression(member.name, place.Below(ViewOf(member.name)))) return false;
    }
    return true;
  }

  Vetted& vetted_;
  ReferenceTable references_;
  bool is_2020_ = false;
  std::unordered_set<const Value*> seen_;
  std::vector<const Value*> schemas_;  // seen, in order
  std::string error_;
};

// Sorted by name, capitals first.
const std::array<Vetter::Keyword, 57> Vetter::kKeywords = {{
    {"$comment", &Vetter::Text},
    {"$defs", &Vetter::SchemaMap},
    {"$dynamicRef", &Vetter::Unchecked},
    {"$id", &Vetter::Text},
    {"$recursiveRef", &Vetter::Unchecked},
    {"$schema", &Vetter::Text},
    {"additionalItems", &Vetter::Schema},
    {"additionalProperties", &Vetter::Schema},
    {"allOf", &Vetter::Schemas},
    {"anyOf", &Vetter::Schemas},
    {"const", &Vetter::Anything},
    {"contains", &Vetter::Schema},
    {"contentEncoding", &Vetter::Text},
    {"contentMediaType", &Vetter::Text},
    {"default", &Vetter::Anything},
    {"definitions", &Vetter::SchemaMap},
    {"dependencies", &Vetter::Dependencies},
    {"dependentRequired", &Vetter::Unchecked},
    {"dependentSchemas", &Vetter::Unchecked},
    {"description", &Vetter::Text},
    {"disallow", &Vetter::Unchecked},
    {"divisibleBy", &Vetter::Unchecked},
    {"else", &Vetter::Schema},
    {"enum", &Vetter::List},
    {"examples", &Vetter::List},
    {"exclusiveMaximum", &Vetter::Number},
    {"exclusiveMinimum", &Vetter::Number},
    {"extends", &Vetter::Unchecked},
    {"format", &Vetter::Text},
    {"if", &Vetter::Schema},
    {"items", &Vetter::Items},
    {"maxContains", &Vetter::Unchecked},
    {"maxItems", &Vetter::Count},
    {"maxLength", &Vetter::Count},
    {"maxProperties", &Vetter::Count},
    {"maximum", &Vetter::Number},
    {"minContains", &Vetter::Unchecked},
    {"minItems", &Vetter::Count},
    {"minLength", &Vetter::Count},
    {"minProperties", &Vetter::Count},
    {"minimum", &Vetter::Number},
    {"multipleOf", &Vetter::Divisor},
    {"not", &Vetter::Schema},
    {"oneOf", &Vetter::Schemas},
    {"pattern", &Vetter::OnePattern},
    {"patternProperties", &Vetter::PatternMap},
    {"prefixItems", &Vetter::Unchecked},
    {"properties", &Vetter::SchemaMap},
    {"propertyNames", &Vetter::Schema},
    {"readOnly", &Vetter::Flag},
    {"required", &Vetter::Names},
    {"then", &Vetter::Schema},
    {"title", &Vetter::Text},
    {"type", &Vetter::Types},
    {"unevaluatedItems", &Vetter::Unchecked},
    {"unevaluatedProperties", &Vetter::Unchecked},
    {"uniqueItems", &Vetter::Flag},
}};

}  // namespace

const Value* Vetted::Reference(const Value& schema) const {
  const auto target = targets.find(&schema);
  return target == targets.end() ? nullptr : target->second;
}

const Value* Vetted::OnlyReference(const Value& schema) const {
  return reference_has_siblings ? nullptr : Reference(schema);
}

Result<std::unique_ptr<const Vetted>> Vet(std::string_view text, std::string_view pointer) {
  auto document = base::ParseJson(text, kLimits);
  if (!document) return Fail(std::move(document.error()));
  auto vetted = std::make_unique<Vetted>();
  vetted->document = std::move(*document);
  if (IsOpenApi(vetted->document)) {
    auto translated = TranslateOpenApi(vetted->document);
    if (!translated) return Fail(ErrorKind::kInvalid, std::move(translated.error()));
  }
  Vetter vetter(*vetted);
  if (!vetter.Run(pointer)) return Fail(vetter.TakeError());
  return vetted;
}

}  // namespace fleetpub::schema
