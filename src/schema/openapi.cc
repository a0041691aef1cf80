#include "schema/openapi.h"

#include <fmt/format.h>

#include <array>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "schema/references.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::FindMember;
using base::ToView;
using rapidjson::SizeType;
using Value = base::JsonValue;

constexpr std::string_view kComponents = "#/components/schemas/";

// Every step says what is wrong by Refuse and returns false; the first one ends the walk.
class Translator {
 public:
  explicit Translator(base::JsonDocument& document)
      : document_(document), allocator_(document.GetAllocator()) {}

  bool Run() {
    const Place root;
    const std::string_view version = base::StringMember(document_, "openapi");
    if (!version.starts_with("3.0.")) {
      return Refuse(root.Below("openapi"),
                    fmt::format("must be 3.0.x, not {}", Shown(*FindMember(document_, "openapi"))));
    }
    Value* components = Member(document_, "components");
    Value* schemas = components == nullptr ? nullptr : Member(*components, "schemas");
    if (schemas == nullptr || !schemas->IsObject()) return true;
    components_ = schemas;
    const Place above = root.Below("components");
    return Map(*schemas, above.Below("schemas"));
  }

  [[nodiscard]] std::string TakeError() { return std::move(error_); }

 private:
  bool Refuse(const Place& place, std::string_view what) {
    error_ = fmt::format("{} {}", base::Printable(place.Pointer()), what);
    return false;
  }

  static Value* Member(Value& object, std::string_view name) {
    return const_cast<Value*>(FindMember(object, name));
  }

  Value Text(std::string_view text) {
    return {text.data(), static_cast<SizeType>(text.size()), allocator_};
  }
  void Add(Value& object, std::string_view name, Value value) {
    object.AddMember(Text(name), value, allocator_);
  }

  // What is no schema stays as it is: the loader says so.
  bool Schema(Value& schema, const Place& place) {
    if (!schema.IsObject() || FindMember(schema, "$ref") != nullptr) return true;
    Nullable(schema);
    Exclusive(schema, "minimum", "exclusiveMinimum");
    Exclusive(schema, "maximum", "exclusiveMaximum");
    if (!Children(schema, place)) return false;
    return Discriminator(schema, place);
  }

  bool Children(Value& schema, const Place& place) {
    for (const std::string_view name : {"items", "additionalProperties", "not"}) {
      Value* child = Member(schema, name);
      if (child != nullptr && !Schema(*child, place.Below(name))) return false;
    }
    for (const std::string_view name : {"allOf", "anyOf", "oneOf"}) {
      Value* list = Member(schema, name);
      if (list == nullptr || !list->IsArray()) continue;
      const Place below = place.Below(name);
      for (SizeType i = 0; i < list->Size(); ++i) {
        if (!Schema((*list)[i], below.Below(i))) return false;
      }
    }
    Value* properties = Member(schema, "properties");
    return properties == nullptr || Map(*properties, place.Below("properties"));
  }

  bool Map(Value& schemas, const Place& place) {
    if (!schemas.IsObject()) return true;
    const auto end = schemas.MemberEnd();
    for (auto it = schemas.MemberBegin(); it < end; ++it) {
      if (!Schema(it->value, place.Below(ToView(it->name)))) return false;
    }
    return true;
  }

  // Without a type, null is allowed already.
  void Nullable(Value& schema) {
    const Value* nullable = FindMember(schema, "nullable");
    Value* type = Member(schema, "type");
    if (nullable == nullptr || !nullable->IsTrue() || type == nullptr || !type->IsString()) return;
    Value types(rapidjson::kArrayType);
    types.PushBack(Text(ToView(*type)), allocator_);
    types.PushBack(Text("null"), allocator_);
    *type = types;
  }

  // As in JSON Schema's draft-04 the exclusive limit is a flag beside the limit.
  void Exclusive(Value& schema, std::string_view limit, std::string_view exclusive) {
    Value* flag = Member(schema, exclusive);
    if (flag == nullptr || !flag->IsBool()) return;
    Value* number = Member(schema, limit);
    if (flag->IsTrue() && number != nullptr) {
      *flag = *number;
      schema.RemoveMember(Text(limit));
    } else {
      schema.RemoveMember(Text(exclusive));
    }
  }

  struct Alternative {
    std::string value;      // of the property
    std::string reference;  // to the schema that it means
  };

  bool Discriminator(Value& schema, const Place& above) {
    const Value* discriminator = FindMember(schema, "discriminator");
    const std::string_view list = FindMember(schema, "oneOf") != nullptr ? "oneOf" : "anyOf";
    Value* alternatives = Member(schema, list);
    if (discriminator == nullptr || alternatives == nullptr) return true;
    const Place place = above.Below("discriminator");
    const Value* property = FindMember(*discriminator, "propertyName");
    if (property == nullptr || !property->IsString()) {
      return Refuse(place, "must name a property with propertyName");
    }
    std::vector<Alternative> meant;
    if (!Mapped(*discriminator, place, meant)) return false;
    if (!Implied(*alternatives, above.Below(list), meant)) return false;
    Value rules = Rules(ToView(*property), meant);
    schema.RemoveMember(Text(list));
    schema.RemoveMember("discriminator");
    if (Value* all = Member(schema, "allOf"); all != nullptr && all->IsArray()) {
      for (Value& rule : rules.GetArray()) all->PushBack(rule, allocator_);
    } else {
      schema.RemoveMember("allOf");
      Add(schema, "allOf", std::move(rules));
    }
    return true;
  }

  bool Mapped(const Value& discriminator, const Place& above, std::vector<Alternative>& meant) {
    const Value* mapping = FindMember(discriminator, "mapping");
    if (mapping == nullptr) return true;
    const Place place = above.Below("mapping");
    if (!mapping->IsObject()) return Refuse(place, "must be an object");
    for (const auto& [name, target] : mapping->GetObject()) {
      if (!target.IsString()) return Refuse(place.Below(ToView(name)), "must be a string");
      const bool is_name = FindMember(*components_, ToView(target)) != nullptr;
      meant.push_back({std::string(ToView(name)),
                       fmt::format("{}{}", is_name ? kComponents : "", ToView(target))});
    }
    return true;
  }

  // An alternative that no mapping leads to is meant by its own name.
  bool Implied(const Value& alternatives, const Place& place, std::vector<Alternative>& meant) {
    if (!alternatives.IsArray()) return Refuse(place, "must be an array");
    std::set<std::string, std::less<>> mapped;
    for (const Alternative& one : meant) mapped.insert(one.reference);
    for (SizeType i = 0; i < alternatives.Size(); ++i) {
      const std::string_view reference = base::StringMember(alternatives[i], "$ref");
      if (reference.empty()) {
        return Refuse(place.Below(i), "must be a reference: a discriminator chooses by name");
      }
      if (mapped.contains(reference)) continue;
      meant.push_back({std::string(reference.substr(reference.rfind('/') + 1)),  //
                       std::string(reference)});
    }
    return true;
  }

  // The property is there and has a known value; each value asks for its schema.
  Value Rules(std::string_view property, const std::vector<Alternative>& meant) {
    Value names(rapidjson::kArrayType);
    for (const Alternative& one : meant) names.PushBack(Text(one.value), allocator_);
    Value known(rapidjson::kObjectType);
    Add(known, "type", Text("string"));
    Add(known, "enum", std::move(names));
    Value rules(rapidjson::kArrayType);
    rules.PushBack(ObjectWith(property, std::move(known)), allocator_);
    for (const Alternative& one : meant) {
      Value same(rapidjson::kObjectType);
      Add(same, "const", Text(one.value));
      Value reference(rapidjson::kObjectType);
      Add(reference, "$ref", Text(one.reference));
      Value rule(rapidjson::kObjectType);
      Add(rule, "if", ObjectWith(property, std::move(same)));
      Add(rule, "then", std::move(reference));
      rules.PushBack(rule, allocator_);
    }
    return rules;
  }

  Value ObjectWith(std::string_view property, Value schema) {
    Value properties(rapidjson::kObjectType);
    Add(properties, property, std::move(schema));
    Value required(rapidjson::kArrayType);
    required.PushBack(Text(property), allocator_);
    Value object(rapidjson::kObjectType);
    Add(object, "type", Text("object"));
    Add(object, "required", std::move(required));
    Add(object, "properties", std::move(properties));
    return object;
  }

  base::JsonDocument& document_;
  base::JsonDocument::AllocatorType& allocator_;
  const Value* components_ = nullptr;
  std::string error_;
};

}  // namespace

bool IsOpenApi(const Value& document) { return FindMember(document, "openapi") != nullptr; }

tl::expected<void, std::string> TranslateOpenApi(base::JsonDocument& document) {
  Translator translator(document);
  if (!translator.Run()) return tl::unexpected(translator.TakeError());
  return {};
}

}  // namespace fleetpub::schema
