#include "schema/explain.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "schema/validator.h"
#include "schema/values.h"
#include "schema/words.h"

namespace fleetpub::schema {
namespace {

using base::FindMember;
using base::ViewOf;
using rapidjson::SizeType;
using Value = base::JsonValue;

// Where in the message. A link of a chain on the stack.
struct Where {
  const Where* up = nullptr;
  std::string_view name = {};  // of a member; data() is null for an item
  std::size_t index = 0;       // among its siblings
};

std::string PointerTo(const Where& where) {
  if (where.up == nullptr) return {};
  const std::string above = PointerTo(*where.up);
  if (where.name.data() == nullptr) return fmt::format("{}/{}", above, where.index);
  return fmt::format("{}/{}", above, base::PointerToken(where.name));
}

std::vector<std::size_t> OrderOf(const Where& where) {
  if (where.up == nullptr) return {};
  std::vector<std::size_t> order = OrderOf(*where.up);
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

class Explainer {
 public:
  Explainer(const Vetted& vetted, std::size_t most) : vetted_(vetted), most_(most) {}

  void Check(const Value& schema, const Value& value, const Where& where) {
    if (findings_.size() > most_) return;
    if (schema.IsBool()) {
      if (schema.IsFalse()) Add(where, "is not allowed");
      return;
    }
    if (const Value* target = vetted_.Reference(schema)) {
      if (--work_left_ < 0) throw TooMuchWork();
      Check(*target, value, where);
    }
    if (vetted_.OnlyReference(schema) != nullptr) return;
    if (!Type(schema, value, where)) return;  // nothing else that is said would help
    Choice(schema, value, where);
    if (value.IsNumber()) Number(schema, value, where);
    if (value.IsString()) Text(schema, value, where);
    if (value.IsArray()) Array(schema, value, where);
    if (value.IsObject()) Object(schema, value, where);
    Combined(schema, value, where);
  }

  Findings Take() { return std::move(findings_); }

 private:
  void Add(const Where& where, std::string message) {
    findings_.push_back({OrderOf(where), {PointerTo(where), std::move(message)}, {}, {}});
  }

  void MustBe(const Where& where, std::string wanted, std::string found) {
    Add(where, fmt::format("must be {}, not {}", wanted, found));
    findings_.back().wanted = std::move(wanted);
    findings_.back().found = std::move(found);
  }

  // What would be found, kept apart.
  Findings Try(const Value& schema, const Value& value, const Where& where) {
    Findings outer = std::exchange(findings_, {});
    Check(schema, value, where);
    return std::exchange(findings_, std::move(outer));
  }

  bool Satisfies(const Value& schema, const Value& value) {
    return Try(schema, value, Where()).empty();
  }

  bool Type(const Value& schema, const Value& value, const Where& where) {
    const Value* type = FindMember(schema, "type");
    if (type == nullptr) return true;
    const auto fits = [&value](const Value& name) { return IsOfType(value, ViewOf(name)); };
    if (type->IsString() ? fits(*type) : std::any_of(type->Begin(), type->End(), fits)) return true;
    const Value* choice = FindMember(schema, "enum");
    MustBe(where,
           choice != nullptr && !choice->Empty() ? ChoiceInWords(*choice) : TypeInWords(schema),
           KindInWords(value, schema));
    return false;
  }

  void Choice(const Value& schema, const Value& value, const Where& where) {
    const auto equal = [&value](const Value& other) { return Equal(value, other); };
    const Value* values = FindMember(schema, "enum");
    if (values != nullptr && values->Empty()) return Add(where, "is not allowed");
    if (values != nullptr && std::none_of(values->Begin(), values->End(), equal)) {
      MustBe(where, ChoiceInWords(*values), Shown(value));
    }
    const Value* constant = FindMember(schema, "const");
    if (constant == nullptr || equal(*constant)) return;
    if (constant->IsObject() || constant->IsArray()) {
      return Add(where, "must be exactly what the schema's const says");
    }
    MustBe(where, Shown(*constant), Shown(value));
  }

  void Number(const Value& schema, const Value& value, const Where& where) {
    const double number = value.GetDouble();
    const auto breaks = [&](std::string_view keyword, auto beyond) {
      const Value* limit = FindMember(schema, keyword);
      return limit != nullptr && beyond(number, limit->GetDouble());
    };
    if (breaks("minimum", std::less<>()) || breaks("maximum", std::greater<>()) ||
        breaks("exclusiveMinimum", std::less_equal<>()) ||
        breaks("exclusiveMaximum", std::greater_equal<>())) {
      const Value* type = FindMember(schema, "type");
      const bool typed = type != nullptr && type->IsString();
      MustBe(where, typed ? TypeInWords(schema) : RangeInWords(schema), Shown(value));
    }
    const Value* divisor = FindMember(schema, "multipleOf");
    if (divisor != nullptr && !IsMultipleOf(value, *divisor)) {
      MustBe(where, fmt::format("a multiple of {}", Shown(*divisor)), Shown(value));
    }
  }

  void Text(const Value& schema, const Value& value, const Where& where) {
    const std::string_view text = ViewOf(value);
    Size(schema, "minLength", "maxLength", CountCharacters(text), "character", where);
    const Value* pattern = FindMember(schema, "pattern");
    if (pattern != nullptr && !vetted_.patterns.at(pattern).Matches(text)) {
      Add(where, fmt::format("must match the pattern {}, which {} does not",
                             base::Printable(ViewOf(*pattern)), Shown(value)));
    }
    if (base::StringMember(schema, "format") == "date-time" && !base::ParseDateTime(text)) {
      MustBe(where, "a date-time such as 2026-01-02T03:04:05.678Z", Shown(value));
    }
  }

  void Size(const Value& schema, std::string_view minimum, std::string_view maximum,
            std::uint64_t size, std::string_view noun, const Where& where) {
    const Value* least = FindMember(schema, minimum);
    const Value* most = FindMember(schema, maximum);
    if (least != nullptr && size < AsCount(*least)) {
      Add(where,
          fmt::format("must have at least {}, has {}", Counted(AsCount(*least), noun), size));
    }
    if (most != nullptr && size > AsCount(*most)) {
      Add(where, fmt::format("must have at most {}, has {}", Counted(AsCount(*most), noun), size));
    }
  }

  void Array(const Value& schema, const Value& array, const Where& where) {
    Size(schema, "minItems", "maxItems", array.Size(), "item", where);
    const Value* unique = FindMember(schema, "uniqueItems");
    if (unique != nullptr && unique->GetBool()) {
      if (const auto repeat = FirstRepeat(array)) {
        Add(where, fmt::format("must not hold an item twice: items {} and {} are equal",
                               repeat->first, repeat->second));
      }
    }
    const Value* contains = FindMember(schema, "contains");
    if (contains != nullptr && std::none_of(array.Begin(), array.End(), [&](const Value& item) {
          return Satisfies(*contains, item);
        })) {
      Add(where, "must contain an item of the kind that the schema's contains asks for");
    }
    Items(schema, array, where);
  }

  void Items(const Value& schema, const Value& array, const Where& where) {
    const Value* items = FindMember(schema, "items");
    if (items == nullptr) return;
    const Value* others = items->IsArray() ? FindMember(schema, "additionalItems") : items;
    const SizeType listed = items->IsArray() ? items->Size() : 0;
    if (others != nullptr && others->IsFalse() && array.Size() > listed) {
      Add(where,
          fmt::format("must have at most {}, has {}", Counted(listed, "item"), array.Size()));
      others = nullptr;
    }
    for (SizeType i = 0; i < array.Size(); ++i) {
      const Value* each = i < listed ? &(*items)[i] : others;
      if (each != nullptr) Check(*each, array[i], {&where, {}, i});
    }
  }

  void Object(const Value& schema, const Value& object, const Where& where) {
    if (const Value* names = FindMember(schema, "required")) {
      Missing(*names, object, where, "required but missing");
    }
    Size(schema, "minProperties", "maxProperties", object.MemberCount(), "member", where);
    Dependencies(schema, object, where);
    const Value* named = FindMember(schema, "propertyNames");
    std::size_t index = 0;
    for (const auto& member : object.GetObject()) {
      const Where below{&where, ViewOf(member.name), index++};
      Member(schema, member, below);
      if (named == nullptr) continue;
      const Findings wrong = Try(*named, member.name, below);
      if (wrong.empty()) continue;
      Add(below, fmt::format("has a name that {}", wrong[0].violation.message));
    }
  }

  void Missing(const Value& names, const Value& object, const Where& where, std::string_view how) {
    std::vector<std::string> missing;
    for (const Value& name : names.GetArray()) {
      if (FindMember(object, ViewOf(name)) == nullptr) {
        missing.push_back(base::Printable(ViewOf(name)));
      }
    }
    if (missing.empty()) return;
    Add(where, fmt::format("{} {} {}", base::Join(missing, ", "),
                           missing.size() == 1 ? "is" : "are", how));
  }

  void Dependencies(const Value& schema, const Value& object, const Where& where) {
    const Value* dependencies = FindMember(schema, "dependencies");
    if (dependencies == nullptr) return;
    for (const auto& [name, needs] : dependencies->GetObject()) {
      if (FindMember(object, ViewOf(name)) == nullptr) continue;
      if (needs.IsArray()) {
        Missing(needs, object, where,
                fmt::format("required beside {} but missing", base::Printable(ViewOf(name))));
      } else {
        Check(needs, object, where);
      }
    }
  }

  void Member(const Value& schema, const Value::Member& member, const Where& where) {
    const std::string_view name = ViewOf(member.name);
    const Value* properties = FindMember(schema, "properties");
    const Value* known = properties == nullptr ? nullptr : FindMember(*properties, name);
    bool matched = known != nullptr;
    if (known != nullptr) Check(*known, member.value, where);
    if (const Value* matching = FindMember(schema, "patternProperties")) {
      for (const auto& each : matching->GetObject()) {
        if (!vetted_.patterns.at(&each.name).Matches(name)) continue;
        matched = true;
        Check(each.value, member.value, where);
      }
    }
    const Value* others = FindMember(schema, "additionalProperties");
    if (matched || others == nullptr) return;
    if (others->IsFalse()) return Unknown(properties, name, where);
    Check(*others, member.value, where);
  }

  void Unknown(const Value* properties, std::string_view name, const Where& where) {
    std::vector<std::string_view> known;
    if (properties != nullptr) {
      for (const auto& member : properties->GetObject()) known.push_back(ViewOf(member.name));
    }
    const auto near = base::Nearest(name, known);
    Add(where, near ? fmt::format("is not known here; did you mean {}?", base::Printable(*near))
                    : "is not known here");
  }

  void Combined(const Value& schema, const Value& value, const Where& where) {
    if (const Value* all = FindMember(schema, "allOf")) {
      for (const Value& each : all->GetArray()) Check(each, value, where);
    }
    if (const Value* any = FindMember(schema, "anyOf")) Some(*any, value, where, any->Size());
    if (const Value* one = FindMember(schema, "oneOf")) Some(*one, value, where, 1);
    const Value* excluded = FindMember(schema, "not");
    if (excluded != nullptr && Satisfies(*excluded, value)) Excluded(*excluded, value, where);
    if (const Value* condition = FindMember(schema, "if")) {
      const Value* then = FindMember(schema, Satisfies(*condition, value) ? "then" : "else");
      if (then != nullptr) Check(*then, value, where);
    }
  }

  void Excluded(const Value& schema, const Value& value, const Where& where) {
    const Value* names = FindMember(schema, "required");
    if (names != nullptr && schema.MemberCount() == 1 && value.IsObject() && names->Size() == 1) {
      return Add(where, fmt::format("must not have {}", base::Printable(ViewOf((*names)[0]))));
    }
    if (const std::string type = TypeInWords(schema); !type.empty() && schema.MemberCount() == 1) {
      return Add(where, fmt::format("must not be {}", type));
    }
    Add(where, fmt::format("must not be {}, which the schema's not excludes", Shown(value)));
  }

  // At least one and at most `most` of the alternatives must hold.
  void Some(const Value& alternatives, const Value& value, const Where& where, SizeType most) {
    std::vector<Findings> wrong;
    for (const Value& each : alternatives.GetArray()) wrong.push_back(Try(each, value, where));
    const auto fit = static_cast<SizeType>(
        std::count_if(wrong.begin(), wrong.end(), [](const Findings& f) { return f.empty(); }));
    if (fit > most) {
      return Add(where, fmt::format("matches {} of {} alternatives, must match exactly one", fit,
                                    alternatives.Size()));
    }
    if (fit == 0) Nearest(wrong, where);
  }

  // Says what keeps the value from the alternative that it comes nearest to.
  void Nearest(std::vector<Findings>& wrong, const Where& where) {
    const std::size_t depth = OrderOf(where).size();
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
      const std::string below = first.path.substr(PointerTo(where).size());
      parts.push_back(below.empty() ? first.message : fmt::format("{} {}", below, first.message));
    }
    Add(where,
        fmt::format("matches none of {} alternatives: {}", wrong.size(), Alternatives(parts)));
  }

  const Vetted& vetted_;
  const std::size_t most_;
  int work_left_ = kMostWork;
  Findings findings_;
};

}  // namespace

std::vector<Violation> Explain(const Vetted& vetted, const Value& message, std::size_t most) {
  Explainer explainer(vetted, most);
  explainer.Check(*vetted.root, message, Where());
  Findings findings = explainer.Take();
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.order < b.order; });
  std::vector<Violation> violations;
  for (Finding& finding : findings) {
    if (std::find(violations.begin(), violations.end(), finding.violation) == violations.end()) {
      violations.push_back(std::move(finding.violation));
    }
  }
  if (violations.size() > most) {
    violations.resize(most);
    violations.push_back(
        {"", fmt::format("has more than {} violations; the rest is not listed", most)});
  }
  return violations;
}

}  // namespace fleetpub::schema
