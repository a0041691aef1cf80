#include "schema/validator.h"

// valijson. We keep its rules and its walk, and give it three things of our own:
//
//  - Adapter: how it sees a base::JsonValue. Its own one refuses 1.0 as an integer, takes 2^63 for
//    a negative number and copies strings.
//  - Rule: constraints in place of those that use std::regex (pattern, patternProperties, format),
//    that end a string at NUL (minLength, maxLength), that round (multipleOf), or that take
//    quadratic time (uniqueItems).
//  - Builder: makes valijson's constraints from a vetted schema, in place of valijson::SchemaParser,
//    whose references miss (`$id`; names with a slash; `propertyNames` beside a reference to the
//    whole) or recurse without end.
#define VALIJSON_USE_EXCEPTIONS 1
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <valijson/constraints/concrete_constraints.hpp>
#include <valijson/internal/basic_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/validation_visitor.hpp>
#include <vector>

#include "base/json.h"
#include "base/time.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::ViewOf;
using rapidjson::SizeType;
using Value = base::JsonValue;
using valijson::Subschema;
namespace constraints = valijson::constraints;

// --- Adapter
// ---------------------------------------------------------------------------------------------------------

class Adapter;
using Member = std::pair<std::string, Adapter>;

// An iterator of rapidjson's whose `*` makes what valijson wants to see: an Adapter or a Member.
template <typename Seen, typename Base>
class Iterator {
 public:
  explicit Iterator(Base at) : at_(at) {}
  Seen operator*() const;
  valijson::adapters::DerefProxy<Seen> operator->() const {
    return valijson::adapters::DerefProxy<Seen>(**this);
  }
  bool operator==(const Iterator& other) const { return at_ == other.at_; }
  Iterator& operator++() { return ++at_, *this; }
  Iterator operator++(int) { return Iterator(at_++); }
  Iterator& operator--() { return --at_, *this; }
  void advance(std::ptrdiff_t n) { at_ += n; }

 private:
  Base at_;
};

const Value kNoItems(rapidjson::kArrayType);
const Value kNoMembers(rapidjson::kObjectType);

class Array {
 public:
  using const_iterator = Iterator<Adapter, Value::ConstValueIterator>;

  explicit Array(const Value& value = kNoItems) : value_(&value) {}
  [[nodiscard]] const_iterator begin() const { return const_iterator(value_->Begin()); }
  [[nodiscard]] const_iterator end() const { return const_iterator(value_->End()); }
  [[nodiscard]] std::size_t size() const { return value_->Size(); }

 private:
  const Value* value_;
};

class Object {
 public:
  using const_iterator = Iterator<Member, Value::ConstMemberIterator>;

  explicit Object(const Value& value = kNoMembers) : value_(&value) {}
  [[nodiscard]] const_iterator begin() const { return const_iterator(value_->MemberBegin()); }
  [[nodiscard]] const_iterator end() const { return const_iterator(value_->MemberEnd()); }
  [[nodiscard]] std::size_t size() const { return value_->MemberCount(); }
  [[nodiscard]] const_iterator find(const std::string& name) const {
    return const_iterator(
        value_->FindMember(Value(rapidjson::StringRef(name.data(), name.size()))));
  }

 private:
  const Value* value_;
};

// A value of `enum` or `const`. It stays in the schema's document: nothing is copied.
class Frozen : public valijson::adapters::FrozenValue {
 public:
  explicit Frozen(const Value& value) : value_(value) {}
  [[nodiscard]] FrozenValue* clone() const override { return new Frozen(value_); }
  [[nodiscard]] bool equalTo(const valijson::adapters::Adapter& other, bool strict) const override;

 private:
  const Value& value_;
};

class Seen {
 public:
  explicit Seen(const Value& value = kNoMembers) : value_(&value) {}

  [[nodiscard]] valijson::adapters::FrozenValue* freeze() const { return new Frozen(*value_); }
  [[nodiscard]] opt::optional<Array> getArrayOptional() const {
    return isArray() ? opt::make_optional(Array(*value_)) : opt::optional<Array>();
  }
  [[nodiscard]] opt::optional<Object> getObjectOptional() const {
    return isObject() ? opt::make_optional(Object(*value_)) : opt::optional<Object>();
  }
  bool getArraySize(std::size_t& size) const { return isArray() && (size = value_->Size(), true); }
  bool getObjectSize(std::size_t& size) const {
    return isObject() && (size = value_->MemberCount(), true);
  }
  bool getBool(bool& result) const { return isBool() && (result = value_->GetBool(), true); }
  bool getDouble(double& result) const {
    return isDouble() && (result = value_->GetDouble(), true);
  }
  // Numbers are compared as doubles.
  static bool getInteger(std::int64_t& /*result*/) { return false; }
  bool getString(std::string& result) const {
    return isString() && (result.assign(ViewOf(*value_)), true);
  }

  static bool hasStrictTypes() { return true; }
  [[nodiscard]] bool isArray() const { return value_->IsArray(); }
  [[nodiscard]] bool isBool() const { return value_->IsBool(); }
  [[nodiscard]] bool isDouble() const { return value_->IsNumber(); }
  [[nodiscard]] bool isInteger() const { return IsInteger(*value_); }
  [[nodiscard]] bool isNull() const { return value_->IsNull(); }
  [[nodiscard]] bool isNumber() const { return value_->IsNumber(); }
  [[nodiscard]] bool isObject() const { return value_->IsObject(); }
  [[nodiscard]] bool isString() const { return value_->IsString(); }

 private:
  const Value* value_;
};

class Adapter final
    : public valijson::adapters::BasicAdapter<Adapter, Array, Member, Object, Seen> {
 public:
  Adapter() = default;
  explicit Adapter(const Value& value) : BasicAdapter(Seen(value)), value_(&value) {}
  [[nodiscard]] const Value& value() const { return *value_; }

 private:
  const Value* value_ = &kNoMembers;
};

template <>
Adapter Iterator<Adapter, Value::ConstValueIterator>::operator*() const {
  return Adapter(*at_);
}

template <>
Member Iterator<Member, Value::ConstMemberIterator>::operator*() const {
  return {std::string(ViewOf(at_->name)), Adapter(at_->value)};
}

// Calls with the value that valijson looks at. Beneath `propertyNames` that is a name, seen by an
// adapter of valijson's.
template <typename Predicate>
bool Ask(const Predicate& predicate, const valijson::adapters::Adapter& target) {
  if (const auto* ours = dynamic_cast<const Adapter*>(&target)) return predicate(ours->value());
  const std::string name = target.getString();
  return predicate(Value(rapidjson::StringRef(name.data(), name.size())));
}

bool Frozen::equalTo(const valijson::adapters::Adapter& other, bool /*strict*/) const {
  return Ask([this](const Value& value) { return Equal(value_, value); }, other);
}

// --- Rules of our own
// ------------------------------------------------------------------------------------------------

template <typename Predicate>
class Rule final : public constraints::PolyConstraint {
 public:
  explicit Rule(Predicate predicate) : predicate_(std::move(predicate)) {}

  [[nodiscard]] bool validate(const valijson::adapters::Adapter& target,
                              const std::vector<std::string>& /*context*/,
                              valijson::ValidationResults* /*results*/) const override {
    return Ask(predicate_, target);
  }

 private:
  constraints::Constraint* cloneInto(void* memory) const override {
    return new (memory) Rule(predicate_);
  }
  [[nodiscard]] std::size_t sizeOf() const override { return sizeof(Rule); }

  Predicate predicate_;
};

bool IsValidBy(const Subschema& schema, const Value& value) {
  std::unordered_map<std::string, std::regex> none;
  valijson::ValidationVisitor<Adapter> visitor(Adapter(value), {}, true, nullptr, none);
  return visitor.validateSchema(schema);
}

thread_local int work_left = 0;

void Spend() {
  if (--work_left < 0) throw TooMuchWork();
}

}  // namespace

// --- Builder
// ---------------------------------------------------------------------------------------------------------

class Validator::Rules {
 public:
  explicit Rules(const Vetted& vetted) : vetted_(vetted) {
    for (const auto& [from, target] : vetted.targets) shared_.emplace(target, nullptr);
    if (shared_.contains(vetted.root)) shared_[vetted.root] = &root_;
    todo_.emplace_back(vetted.root, &root_);
    while (!todo_.empty()) {  // no recursion: references lead as deep as they like
      const auto [schema, subschema] = todo_.back();
      todo_.pop_back();
      Build(*schema, subschema);
    }
  }

  [[nodiscard]] bool IsValid(const Value& message) const {
    work_left = kMostWork;
    return IsValidBy(root_, message);
  }

 private:
  using Builder = void (Rules::*)(const Value& schema, const Value& value, const Subschema* into);
  struct Keyword {
    std::string_view name;
    Builder build;
  };
  static const std::array<Keyword, 30> kKeywords;

  void Build(const Value& schema, const Subschema* into);

  template <typename Constraint>
  void Add(const Constraint& constraint, const Subschema* into) {
    root_.addConstraintToSubschema(constraint, into);
  }

  template <typename Predicate>
  void AddRule(Predicate predicate, const Subschema* into) {
    Add(Rule<Predicate>(std::move(predicate)), into);
  }

  const Subschema* Make(const Value& schema) {
    const Value* target = &schema;
    while (const Value* next = vetted_.OnlyReference(*target)) target = next;
    const auto shared = shared_.find(target);
    if (shared != shared_.end() && shared->second != nullptr) return shared->second;
    const Subschema* subschema = root_.createSubschema();
    if (shared != shared_.end()) shared->second = subschema;
    todo_.emplace_back(target, subschema);
    return subschema;
  }

  template <typename Constraint>
  void Several(const Value& /*schema*/, const Value& value, const Subschema* into) {
    Constraint constraint;
    for (const Value& each : value.GetArray()) constraint.addSubschema(Make(each));
    Add(constraint, into);
  }

  template <typename Constraint>
  void Single(const Value& /*schema*/, const Value& value, const Subschema* into) {
    Constraint constraint;
    constraint.setSubschema(Make(value));
    Add(constraint, into);
  }

  template <typename Constraint, void (Constraint::*kSet)(std::uint64_t)>
  void Limit(const Value& /*schema*/, const Value& value, const Subschema* into) {
    Constraint constraint;
    (constraint.*kSet)(AsCount(value));
    Add(constraint, into);
  }

  void Condition(const Value& schema, const Value& value, const Subschema* into) {
    constraints::ConditionalConstraint constraint;
    constraint.setIfSubschema(Make(value));
    if (const Value* then = base::FindMember(schema, "then")) {
      constraint.setThenSubschema(Make(*then));
    }
    if (const Value* otherwise = base::FindMember(schema, "else")) {
      constraint.setElseSubschema(Make(*otherwise));
    }
    Add(constraint, into);
  }

  void Const(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::ConstConstraint constraint;
    constraint.setValue(Adapter(value));
    Add(constraint, into);
  }

  void Enum(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::EnumConstraint constraint;
    for (const Value& each : value.GetArray()) constraint.addValue(Frozen(each));
    Add(constraint, into);
  }

  void Dependencies(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::DependenciesConstraint constraint;
    for (const auto& [name, needs] : value.GetObject()) {
      if (needs.IsArray()) {
        std::vector<std::string> names;
        for (const Value& need : needs.GetArray()) names.emplace_back(ViewOf(need));
        constraint.addPropertyDependencies(std::string(ViewOf(name)), names);
      } else {
        constraint.addSchemaDependency(std::string(ViewOf(name)), Make(needs));
      }
    }
    Add(constraint, into);
  }

  void Required(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::RequiredConstraint constraint;
    for (const Value& name : value.GetArray()) constraint.addRequiredProperty(name.GetString());
    Add(constraint, into);
  }

  void Types(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::TypeConstraint constraint;
    const auto add = [&constraint](const Value& type) {
      constraint.addNamedType(constraint.jsonTypeFromString(std::string(ViewOf(type))));
    };
    if (value.IsString()) {
      add(value);
    } else {
      for (const Value& type : value.GetArray()) add(type);
    }
    Add(constraint, into);
  }

  template <bool kExclusive>
  void Minimum(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::MinimumConstraint constraint;
    constraint.setMinimum(value.GetDouble());
    constraint.setExclusiveMinimum(kExclusive);
    Add(constraint, into);
  }

  template <bool kExclusive>
  void Maximum(const Value& /*schema*/, const Value& value, const Subschema* into) {
    constraints::MaximumConstraint constraint;
    constraint.setMaximum(value.GetDouble());
    constraint.setExclusiveMaximum(kExclusive);
    Add(constraint, into);
  }

  void Items(const Value& schema, const Value& value, const Subschema* into) {
    if (!value.IsArray()) {
      constraints::SingularItemsConstraint constraint;
      constraint.setItemsSubschema(Make(value));
      return Add(constraint, into);
    }
    constraints::LinearItemsConstraint constraint;
    for (const Value& each : value.GetArray()) constraint.addItemSubschema(Make(each));
    const Value* others = base::FindMember(schema, "additionalItems");
    constraint.setAdditionalItemsSubschema(others == nullptr ? root_.emptySubschema()
                                                             : Make(*others));
    Add(constraint, into);
  }

  void Format(const Value& /*schema*/, const Value& value, const Subschema* into) {
    if (ViewOf(value) != "date-time") return;  // an annotation (draft-07 §7.2)
    AddRule(
        [](const Value& text) {
          return !text.IsString() || base::ParseDateTime(ViewOf(text)).has_value();
        },
        into);
  }

  void OnePattern(const Value& /*schema*/, const Value& value, const Subschema* into) {
    AddRule([pattern = &vetted_.patterns.at(&value)](
                const Value& text) { return !text.IsString() || pattern->Matches(ViewOf(text)); },
            into);
  }

  void MinLength(const Value& /*schema*/, const Value& value, const Subschema* into) {
    AddRule(
        [least = AsCount(value)](const Value& text) {
          return !text.IsString() || CountCharacters(ViewOf(text)) >= least;
        },
        into);
  }

  void MaxLength(const Value& /*schema*/, const Value& value, const Subschema* into) {
    AddRule(
        [most = AsCount(value)](const Value& text) {
          return !text.IsString() || CountCharacters(ViewOf(text)) <= most;
        },
        into);
  }

  void MultipleOf(const Value& /*schema*/, const Value& value, const Subschema* into) {
    AddRule(
        [divisor = &value](const Value& number) {
          return !number.IsNumber() || IsMultipleOf(number, *divisor);
        },
        into);
  }

  void UniqueItems(const Value& /*schema*/, const Value& value, const Subschema* into) {
    if (!value.GetBool()) return;
    AddRule([](const Value& array) { return !array.IsArray() || !FirstRepeat(array); }, into);
  }

  void Properties(const Value& schema, const Value& value, const Subschema* into);

  const Vetted& vetted_;
  valijson::Schema root_;
  std::vector<std::pair<const Value*, const Subschema*>> todo_;
  std::unordered_map<const Value*, const Subschema*> shared_;  // those that are referred to
};

// `properties`, `patternProperties` and `additionalProperties` in one pass over the message's
// members. valijson's own would match the second with std::regex, and copies every name into a set:
// with it, checking an instantActions message takes four times as long.
struct PropertyRules {
  std::vector<std::pair<std::string_view, const Subschema*>> named;  // sorted
  std::vector<std::pair<const Pattern*, const Subschema*>> matching;
  const Subschema* others = nullptr;  // null: whatever

  [[nodiscard]] bool AllowMember(std::string_view name, const Value& value) const {
    bool known = false;
    const auto it = std::lower_bound(named.begin(), named.end(), name,
                                     [](const auto& a, std::string_view b) { return a.first < b; });
    if (it != named.end() && it->first == name) {
      known = true;
      if (!IsValidBy(*it->second, value)) return false;
    }
    for (const auto& [pattern, subschema] : matching) {
      if (!pattern->Matches(name)) continue;
      known = true;
      if (!IsValidBy(*subschema, value)) return false;
    }
    return known || others == nullptr || IsValidBy(*others, value);
  }
};

void Validator::Rules::Properties(const Value& schema, const Value& value, const Subschema* into) {
  const Value* named = base::FindMember(schema, "properties");
  const Value* matching = base::FindMember(schema, "patternProperties");
  const Value* others = base::FindMember(schema, "additionalProperties");
  if (&value != (named != nullptr ? named : matching != nullptr ? matching : others))
    return;  // once
  auto rules = std::make_shared<PropertyRules>();
  if (named != nullptr) {
    for (const auto& member : named->GetObject()) {
      rules->named.emplace_back(ViewOf(member.name), Make(member.value));
    }
    std::sort(rules->named.begin(), rules->named.end());
  }
  if (matching != nullptr) {
    for (const auto& member : matching->GetObject()) {
      rules->matching.emplace_back(&vetted_.patterns.at(&member.name), Make(member.value));
    }
  }
  if (others != nullptr) rules->others = Make(*others);
  AddRule(
      [rules = std::shared_ptr<const PropertyRules>(std::move(rules))](const Value& object) {
        return !object.IsObject() ||
               std::all_of(object.MemberBegin(), object.MemberEnd(), [&rules](const auto& member) {
                 return rules->AllowMember(ViewOf(member.name), member.value);
               });
      },
      into);
}

const std::array<Validator::Rules::Keyword, 30> Validator::Rules::kKeywords = {{
    {"additionalProperties", &Rules::Properties},
    {"allOf", &Rules::Several<constraints::AllOfConstraint>},
    {"anyOf", &Rules::Several<constraints::AnyOfConstraint>},
    {"const", &Rules::Const},
    {"contains", &Rules::Single<constraints::ContainsConstraint>},
    {"dependencies", &Rules::Dependencies},
    {"enum", &Rules::Enum},
    {"exclusiveMaximum", &Rules::Maximum<true>},
    {"exclusiveMinimum", &Rules::Minimum<true>},
    {"format", &Rules::Format},
    {"if", &Rules::Condition},
    {"items", &Rules::Items},
    {"maxItems",
     &Rules::Limit<constraints::MaxItemsConstraint, &constraints::MaxItemsConstraint::setMaxItems>},
    {"maxLength", &Rules::MaxLength},
    {"maxProperties", &Rules::Limit<constraints::MaxPropertiesConstraint,
                                    &constraints::MaxPropertiesConstraint::setMaxProperties>},
    {"maximum", &Rules::Maximum<false>},
    {"minItems",
     &Rules::Limit<constraints::MinItemsConstraint, &constraints::MinItemsConstraint::setMinItems>},
    {"minLength", &Rules::MinLength},
    {"minProperties", &Rules::Limit<constraints::MinPropertiesConstraint,
                                    &constraints::MinPropertiesConstraint::setMinProperties>},
    {"minimum", &Rules::Minimum<false>},
    {"multipleOf", &Rules::MultipleOf},
    {"not", &Rules::Single<constraints::NotConstraint>},
    {"oneOf", &Rules::Several<constraints::OneOfConstraint>},
    {"pattern", &Rules::OnePattern},
    {"patternProperties", &Rules::Properties},
    {"properties", &Rules::Properties},
    {"propertyNames", &Rules::Single<constraints::PropertyNamesConstraint>},
    {"required", &Rules::Required},
    {"type", &Rules::Types},
    {"uniqueItems", &Rules::UniqueItems},
}};

void Validator::Rules::Build(const Value& schema, const Subschema* into) {
  if (schema.IsBool()) return root_.setAlwaysInvalid(into, schema.IsFalse());
  if (shared_.contains(&schema)) AddRule([](const Value&) { return Spend(), true; }, into);
  if (const Value* target = vetted_.Reference(schema)) {
    constraints::AllOfConstraint constraint;
    constraint.addSubschema(Make(*target));
    Add(constraint, into);
  }
  if (vetted_.OnlyReference(schema) != nullptr) return;
  for (const auto& [name, value] : schema.GetObject()) {
    const std::string_view keyword = ViewOf(name);
    const auto* known =
        std::lower_bound(kKeywords.begin(), kKeywords.end(), keyword,
                         [](const Keyword& k, std::string_view n) { return k.name < n; });
    if (known == kKeywords.end() || known->name != keyword) continue;
    (this->*known->build)(schema, value, into);
  }
}

Validator::Validator(const Vetted& vetted) : rules_(std::make_unique<const Rules>(vetted)) {}
Validator::~Validator() = default;

bool Validator::IsValid(const Value& message) const { return rules_->IsValid(message); }

}  // namespace fleetpub::schema
