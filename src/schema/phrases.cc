#include "schema/phrases.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "schema/values.h"

namespace fleetpub::schema {
namespace {

using base::ToView;
using Value = base::JsonValue;

std::string WithArticle(std::string_view type) {
  if (type == "null") return "null";
  if (type == "boolean") return "true or false";
  const bool vowel = type == "array" || type == "integer" || type == "object";
  return fmt::format("{} {}", vowel ? "an" : "a", type);
}

std::vector<std::string> ListTypes(const Value& schema) {
  const Value* type = base::FindMember(schema, "type");
  if (type == nullptr) return {};
  if (type->IsString()) return {std::string(ToView(*type))};
  std::vector<std::string> types;
  for (const Value& each : type->GetArray()) types.emplace_back(ToView(each));
  return types;
}

// A plain word without its quotation marks.
std::string Choice(const Value& value) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  if (!value.IsString()) return Shown(value);
  const std::string_view text = ToView(value);
  const bool word =
      !text.empty() && text.size() <= 40 && std::all_of(text.begin(), text.end(), plain);
  return word ? std::string(text) : Shown(value);
}

}  // namespace

std::string RangePhrase(const Value& schema) {
  const Value* minimum = base::FindMember(schema, "minimum");
  const Value* maximum = base::FindMember(schema, "maximum");
  const Value* above = base::FindMember(schema, "exclusiveMinimum");
  const Value* below = base::FindMember(schema, "exclusiveMaximum");
  if (minimum != nullptr && maximum != nullptr && above == nullptr && below == nullptr) {
    return fmt::format("between {} and {}", Shown(*minimum), Shown(*maximum));
  }
  std::vector<std::string> limits;
  const std::array<std::pair<const Value*, std::string_view>, 4> all = {
      {{minimum, "at least"}, {above, "more than"}, {maximum, "at most"}, {below, "less than"}}};
  for (const auto& [limit, phrases] : all) {
    if (limit != nullptr) limits.push_back(fmt::format("{} {}", phrases, Shown(*limit)));
  }
  return base::Join(limits, " and ");
}

std::string TypePhrase(const Value& schema) {
  std::vector<std::string> phrases;
  const std::string range = RangePhrase(schema);
  for (const std::string& type : ListTypes(schema)) {
    const bool ranged = !range.empty() && (type == "integer" || type == "number");
    phrases.push_back(ranged ? fmt::format("{}{} {}", WithArticle(type),
                                           range.starts_with("between") ? "" : ",", range)
                             : WithArticle(type));
  }
  // A number is named once: every integer is one.
  if (phrases.size() > 1 && std::count(phrases.begin(), phrases.end(), "a number") > 0) {
    phrases.erase(std::remove(phrases.begin(), phrases.end(), "an integer"), phrases.end());
  }
  return Alternatives(phrases);
}

std::string KindPhrase(const Value& value, const Value& schema) {
  if (value.IsNumber()) {
    const auto types = ListTypes(schema);
    const bool wants_integer = std::find(types.begin(), types.end(), "integer") != types.end();
    return wants_integer ? Shown(value) : "a number";
  }
  return value.IsBool() ? Shown(value) : WithArticle(TypeName(value));
}

std::string ChoicePhrase(const Value& values) {
  constexpr rapidjson::SizeType kMost = 12;
  if (values.Size() == 1) return Choice(values[0]);
  std::vector<std::string> phrases;
  for (rapidjson::SizeType i = 0; i < std::min(values.Size(), kMost); ++i) {
    phrases.push_back(Choice(values[i]));
  }
  const std::string more =
      values.Size() > kMost ? fmt::format(", … ({} in all)", values.Size()) : std::string();
  return fmt::format("one of {}{}", base::Join(phrases, ", "), more);
}

std::string Alternatives(const std::vector<std::string>& parts) {
  if (parts.size() < 2) return parts.empty() ? "" : parts.front();
  const std::vector<std::string> first(parts.begin(), parts.end() - 1);
  return fmt::format("{} or {}", base::Join(first, ", "), parts.back());
}

}  // namespace fleetpub::schema
