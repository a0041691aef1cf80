#include "schema/violations.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "schema/phrases.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::FindMember;
using base::ToView;
using rapidjson::SizeType;
using Value = base::JsonValue;
using Node = SchemaNode;
using Nodes = std::vector<const Node*>;

std::vector<std::size_t> MakeOrder(const Where& where) {
  if (where.up == nullptr) return {};
  std::vector<std::size_t> order = MakeOrder(*where.up);
  order.push_back(where.index);
  return order;
}

struct Finding {
  std::vector<std::size_t> order;  // its place in the message
  Violation violation;
  std::string wanted;  // "must be {wanted}, not {found}", when it is of that form
  std::string found;
};
using Findings = std::vector<Finding>;

// Walks in one of two moods: it collects every violation in words, or it only tries whether there
// is one (for `not`, `if`, `contains` and alternatives) and stops at the first.
class Walk {
 public:
  explicit Walk(int most_work) : work_left_(most_work) {}

  void Check(const Node& schema, const Value& value, const Where& where) {
    if (IsDone()) return;
    if (schema.is_false) {
      if (Violated()) Add(where, "is not allowed");
      return;
    }
    if (schema.reference != nullptr) {
      if (--work_left_ < 0) return;
      Check(*schema.reference, value, where);
    }
    if (!HasType(schema, value)) {  // nothing else that is said would help
      if (Violated()) AddType(schema, value, where);
      return;
    }
    Choice(schema, value, where);
    if (value.IsNumber()) Number(schema, value, where);
    if (value.IsString()) Text(schema, value, where);
    if (value.IsArray()) Array(schema, value, where);
    if (value.IsObject()) Object(schema, value, where);
    Combined(schema, value, where);
  }

  [[nodiscard]] bool gave_up() const { return work_left_ < 0; }
  [[nodiscard]] Findings Take() { return std::move(findings_); }

 private:
  // For each violation: whether it is to be said in words.
  bool Violated() {
    violated_ = true;
    return !trying_;
  }

  [[nodiscard]] bool IsDone() const {
    return gave_up() || (trying_ ? violated_ : findings_.size() > Schema::kMostViolations);
  }

  void Add(const Where& where, std::string message) {
    findings_.push_back({MakeOrder(where), {MakePointer(where), std::move(message)}, {}, {}});
  }

  void MustBe(const Where& where, std::string wanted, std::string found) {
    Add(where, fmt::format("must be {}, not {}", wanted, found));
    findings_.back().wanted = std::move(wanted);
    findings_.back().found = std::move(found);
  }

  // What would be found, kept apart.
  Findings Try(const Node& schema, const Value& value, const Where& where) {
    Findings outer = std::exchange(findings_, {});
    Check(schema, value, where);
    return std::exchange(findings_, std::move(outer));
  }

  bool Satisfies(const Node& schema, const Value& value) {
    const bool trying = std::exchange(trying_, true);
    const bool violated = std::exchange(violated_, false);
    Check(schema, value, Where());
    trying_ = trying;
    return !std::exchange(violated_, violated);
  }

  static bool HasType(const Node& schema, const Value& value) {
    if ((schema.types & (1U << value.GetType())) != 0) return true;
    return value.IsNumber() && (schema.types & Node::kIntegerBit) != 0 && IsInteger(value);
  }

  // Of the schema's own corrections, as its `$comment` names them.
  static bool IsCorrected(const Node& schema, std::string_view what) {
    const std::string_view comment = base::StringMember(*schema.source, "$comment");
    const std::size_t start = comment.find(kCorrected);
    return start != std::string_view::npos &&
           comment.find(what, start + kCorrected.size()) != std::string_view::npos;
  }

  void Append(std::string_view text) { findings_.back().violation.message += text; }

  void AddType(const Node& schema, const Value& value, const Where& where) {
    const Value* choice = schema.choice;
    MustBe(
        where,
        choice != nullptr && !choice->Empty() ? ChoicePhrase(*choice) : TypePhrase(*schema.source),
        KindPhrase(value, *schema.source));
  }

  void Choice(const Node& schema, const Value& value, const Where& where) {
    const auto equal = [&value](const Value& other) { return Equal(value, other); };
    const Value* values = schema.choice;
    if (values != nullptr && std::none_of(values->Begin(), values->End(), equal) && Violated()) {
      if (values->Empty()) return Add(where, "is not allowed");
      MustBe(where, ChoicePhrase(*values), Shown(value));
    }
    const Value* constant = schema.constant;
    if (constant == nullptr || equal(*constant) || !Violated()) return;
    if (constant->IsObject() || constant->IsArray()) {
      return Add(where, "must be exactly what the schema's const says");
    }
    MustBe(where, Shown(*constant), Shown(value));
  }

  void Number(const Node& schema, const Value& value, const Where& where) {
    const double number = value.GetDouble();
    const auto above = [number](const Value* limit) {
      return limit != nullptr && number > limit->GetDouble();
    };
    const auto below = [number](const Value* limit) {
      return limit != nullptr && number < limit->GetDouble();
    };
    const auto beyond = [](const Value* limit, const auto& within) {
      return limit != nullptr && !within(limit);
    };
    const bool outside = below(schema.minimum) || above(schema.maximum) ||
                         beyond(schema.exclusive_minimum, above) ||
                         beyond(schema.exclusive_maximum, below);
    if (outside && Violated()) {
      const Value* type = FindMember(*schema.source, "type");
      const bool typed = type != nullptr && type->IsString();
      MustBe(where, typed ? TypePhrase(*schema.source) : RangePhrase(*schema.source), Shown(value));
      if (IsCorrected(schema, below(schema.minimum) ? "minimum" : "maximum")) {
        Append("; a correction of ours: the published schema has no such limit");
      }
    }
    const Value* divisor = schema.multiple_of;
    if (divisor != nullptr && !IsMultipleOf(value, *divisor) && Violated()) {
      MustBe(where, fmt::format("a multiple of {}", Shown(*divisor)), Shown(value));
    }
  }

  void Text(const Node& schema, const Value& value, const Where& where) {
    const std::string_view text = ToView(value);
    if (schema.min_length != nullptr || schema.max_length != nullptr) {
      Size(schema.min_length, schema.max_length, CountCharacters(text), "character", where);
    }
    if (schema.pattern && !schema.pattern->Matches(text) && Violated()) {
      const std::string_view pattern = base::StringMember(*schema.source, "pattern");
      Add(where, fmt::format("must match the pattern {}, which {} does not",
                             base::Printable(pattern), Shown(value)));
    }
    if (schema.is_date_time && !base::ParseDateTime(text) && Violated()) {
      MustBe(where, "a date-time such as 2026-01-02T03:04:05.678Z", Shown(value));
    }
  }

  void Size(const Value* least, const Value* most, std::uint64_t size, std::string_view noun,
            const Where& where) {
    if (least != nullptr && size < AsCount(*least) && Violated()) {
      Add(where,
          fmt::format("must have at least {}, has {}", base::Counted(AsCount(*least), noun), size));
    }
    if (most != nullptr && size > AsCount(*most) && Violated()) {
      Add(where,
          fmt::format("must have at most {}, has {}", base::Counted(AsCount(*most), noun), size));
    }
  }

  void Array(const Node& schema, const Value& array, const Where& where) {
    Size(schema.min_items, schema.max_items, array.Size(), "item", where);
    if (schema.unique_items) {
      const auto repeat = FirstRepeat(array);
      if (repeat && Violated()) {
        Add(where, fmt::format("must not hold an item twice: items {} and {} are equal",
                               repeat->first, repeat->second));
      }
    }
    const Node* contains = schema.contains;
    const auto fits = [&](const Value& item) { return Satisfies(*contains, item); };
    if (contains != nullptr && std::none_of(array.Begin(), array.End(), fits) && Violated()) {
      Add(where, "must contain an item of the kind that the schema's contains asks for");
    }
    Items(schema, array, where);
  }

  void Items(const Node& schema, const Value& array, const Where& where) {
    const Nodes& listed = schema.listed_items;
    const Node* others = schema.items_are_listed ? schema.additional_items : schema.items;
    if (others != nullptr && others->is_false && array.Size() > listed.size()) {
      if (Violated()) {
        Add(where, fmt::format("must have at most {}, has {}", base::Counted(listed.size(), "item"),
                               array.Size()));
      }
      others = nullptr;
    }
    for (SizeType i = 0; i < array.Size() && !IsDone(); ++i) {
      const Node* each = i < listed.size() ? listed[i] : others;
      if (each == nullptr) return;
      Check(*each, array[i], {&where, {}, i});
    }
  }

  void Object(const Node& schema, const Value& object, const Where& where) {
    if (schema.required != nullptr) Required(schema, object, where);
    Size(schema.min_properties, schema.max_properties, object.MemberCount(), "member", where);
    Dependencies(schema, object, where);
    std::size_t index = 0;
    for (const auto& member : object.GetObject()) {
      if (IsDone()) return;
      const Where below{&where, ToView(member.name), index++};
      Member(schema, member, below);
      const Node* named = schema.property_names;
      if (named == nullptr || Satisfies(*named, member.name) || !Violated()) continue;
      const Findings wrong = Try(*named, member.name, below);
      if (wrong.empty()) continue;  // given up
      Add(below, fmt::format("has a name that {}", wrong[0].violation.message));
    }
  }

  void Required(const Node& schema, const Value& object, const Where& where) {
    const std::size_t before = findings_.size();
    Missing(*schema.required, object, where, "required but missing");
    if (findings_.size() == before || !IsCorrected(schema, "required")) return;
    std::vector<std::string> corrected;
    bool are_all = true;
    for (const Value& name : schema.required->GetArray()) {
      const bool is_missing = FindMember(object, ToView(name)) == nullptr;
      if (!is_missing) continue;
      if (IsCorrected(schema, ToView(name))) {
        corrected.emplace_back(ToView(name));
      } else {
        are_all = false;
      }
    }
    if (corrected.empty()) return;
    Append(fmt::format("; a correction of ours: the published schema does not ask for {}",
                       are_all ? "that" : base::Join(corrected, ", ")));
  }

  void Missing(const Value& names, const Value& object, const Where& where, std::string_view how) {
    std::vector<std::string> missing;
    for (const Value& name : names.GetArray()) {
      if (FindMember(object, ToView(name)) == nullptr && Violated()) {
        missing.push_back(base::Printable(ToView(name)));
      }
    }
    if (missing.empty()) return;
    Add(where, fmt::format("{} {} {}", base::Join(missing, ", "),
                           missing.size() == 1 ? "is" : "are", how));
  }

  void Dependencies(const Node& schema, const Value& object, const Where& where) {
    for (const auto& [name, names, needed] : schema.dependencies) {
      if (FindMember(object, name) == nullptr) continue;
      if (needed != nullptr) {
        Check(*needed, object, where);
      } else {
        Missing(*names, object, where,
                fmt::format("required beside {} but missing", base::Printable(name)));
      }
    }
  }

  void Member(const Node& schema, const Value::Member& member, const Where& where) {
    const std::string_view name = ToView(member.name);
    const Node* known = schema.FindProperty(name);
    bool matched = known != nullptr;
    if (known != nullptr) Check(*known, member.value, where);
    for (const auto& [pattern, each] : schema.pattern_properties) {
      if (!pattern.Matches(name)) continue;
      matched = true;
      Check(*each, member.value, where);
    }
    const Node* others = schema.additional_properties;
    if (matched || others == nullptr) return;
    if (!others->is_false) return Check(*others, member.value, where);
    if (Violated()) Unknown(schema, name, where);
  }

  void Unknown(const Node& schema, std::string_view name, const Where& where) {
    std::vector<std::string_view> known;
    if (const Value* properties = FindMember(*schema.source, "properties")) {
      for (const auto& property : properties->GetObject()) known.push_back(ToView(property.name));
    }
    const auto near = base::Nearest(name, known);
    Add(where, near ? fmt::format("is not known here; did you mean {}?", base::Printable(*near))
                    : "is not known here");
  }

  void Combined(const Node& schema, const Value& value, const Where& where) {
    const auto fits = [&](const Node* each) { return Satisfies(*each, value); };
    for (const Node* each : schema.all_of) Check(*each, value, where);
    const Nodes& any = schema.any_of;
    if (!any.empty() && std::none_of(any.begin(), any.end(), fits) && Violated()) {
      Nearest(any, value, where);
    }
    const Nodes& one = schema.one_of;
    const auto fit = std::count_if(one.begin(), one.end(), fits);
    if (!one.empty() && fit != 1 && Violated()) {
      if (fit == 0)
        Nearest(one, value, where);
      else
        Add(where,
            fmt::format("matches {} of {} alternatives, must match exactly one", fit, one.size()));
    }
    const Node* excluded = schema.excluded;
    if (excluded != nullptr && Satisfies(*excluded, value) && Violated()) {
      Excluded(*excluded->source, value, where);
    }
    if (schema.condition == nullptr) return;
    const Node* then = Satisfies(*schema.condition, value) ? schema.then : schema.otherwise;
    if (then != nullptr) Check(*then, value, where);
  }

  void Excluded(const Value& schema, const Value& value, const Where& where) {
    const Value* names = FindMember(schema, "required");
    const bool alone = schema.IsObject() && schema.MemberCount() == 1;
    if (alone && names != nullptr && value.IsObject() && names->Size() == 1) {
      return Add(where, fmt::format("must not have {}", base::Printable(ToView((*names)[0]))));
    }
    if (const std::string type = TypePhrase(schema); alone && !type.empty()) {
      return Add(where, fmt::format("must not be {}", type));
    }
    Add(where, fmt::format("must not be {}, which the schema's not excludes", Shown(value)));
  }

  // Says what keeps the value from the alternative that it comes nearest to.
  void Nearest(const Nodes& alternatives, const Value& value, const Where& where) {
    std::vector<Findings> wrong;
    for (const Node* each : alternatives) wrong.push_back(Try(*each, value, where));
    if (gave_up()) return;
    const std::size_t depth = MakeOrder(where).size();
    const auto distance = [depth](const Findings& findings) {
      const auto here = std::count_if(findings.begin(), findings.end(), [depth](const Finding& f) {
        return f.order.size() == depth && !f.wanted.empty();
      });
      const auto kinds = std::count_if(findings.begin(), findings.end(),
                                       [](const Finding& f) { return !f.wanted.empty(); });
      return std::tuple(here, kinds, findings.size());
    };
    std::stable_sort(wrong.begin(), wrong.end(), [&](const Findings& a, const Findings& b) {
      return distance(a) < distance(b);
    });
    if (wrong.size() == 1 || distance(wrong[0]) < distance(wrong[1])) {
      for (Finding& finding : wrong[0]) findings_.push_back(std::move(finding));
      return;
    }
    const auto same_place = [depth](const Findings& findings) {
      return findings.size() == 1 && !findings[0].wanted.empty() &&
             findings[0].order.size() == depth;
    };
    std::vector<std::string> parts;
    if (std::all_of(wrong.begin(), wrong.end(), same_place)) {
      for (const Findings& each : wrong) parts.push_back(each[0].wanted);
      return MustBe(where, Alternatives(parts), wrong[0][0].found);
    }
    constexpr std::size_t kMost = 3;
    for (std::size_t i = 0; i < std::min(wrong.size(), kMost); ++i) {
      const Violation& first = wrong[i][0].violation;
      const std::string below = first.path.substr(MakePointer(where).size());
      parts.push_back(below.empty() ? first.message : fmt::format("{} {}", below, first.message));
    }
    Add(where,
        fmt::format("matches none of {} alternatives: {}", wrong.size(), Alternatives(parts)));
  }

  int work_left_;
  bool trying_ = false;
  bool violated_ = false;
  Findings findings_;
};

}  // namespace

std::string MakePointer(const Where& where) {
  if (where.up == nullptr) return {};
  const std::string above = MakePointer(*where.up);
  if (where.name.data() == nullptr) return fmt::format("{}/{}", above, where.index);
  return fmt::format("{}/{}", above, base::PointerToken(where.name));
}

std::vector<Violation> CollectViolations(const CheckedSchema& schema, const Value& message,
                                         int most_work) {
  Walk walk(most_work);
  walk.Check(schema.root(), message, Where());
  if (walk.gave_up()) {
    return {{"", "could not be checked: the schema's references make this message too much work"}};
  }
  Findings findings = walk.Take();
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.order < b.order; });
  std::vector<Violation> violations;
  for (Finding& finding : findings) {
    if (std::find(violations.begin(), violations.end(), finding.violation) == violations.end()) {
      violations.push_back(std::move(finding.violation));
    }
  }
  constexpr std::size_t kMost = Schema::kMostViolations;
  if (violations.size() > kMost) {
    violations.resize(kMost);
    violations.push_back(
        {"", fmt::format("has more than {} violations; the rest is not listed", kMost)});
  }
  return violations;
}

}  // namespace fleetpub::schema
