#include "soar/field.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "base/decimal.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"

namespace fleetpub::soar {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

std::string_view Trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// `--plan-id` and `plan_ID` are one.
std::string Folded(std::string_view word) {
  std::string folded = base::ToLower(word);
  std::replace(folded.begin(), folded.end(), '-', '_');
  return folded;
}

tl::unexpected<Error> Wrong(const Field& field, std::string_view wanted, std::string_view found) {
  constexpr std::size_t kShown = 60;
  const std::string_view start = found.substr(0, kShown);
  const auto right =
      field.type == FieldType::kNumber ? base::WithDecimalPoint(start) : std::nullopt;
  return Fail(ErrorKind::kInvalid,
              fmt::format("{} must be {}, not '{}{}'{}", field.name, wanted, base::Printable(start),
                          start.size() < found.size() ? "..." : "",
                          right ? fmt::format("; write {}", *right) : ""));
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string Choices(const Field& field) {
  std::vector<std::string> names;
  for (const std::string_view choice : field.choices) {
    if (!choice.empty()) names.emplace_back(choice);
  }
  return base::Join(names, ", ");
}

Result<std::string> ParseText(const Field& field, std::string_view text) {
  if (!base::IsUtf8(text)) return Wrong(field, "valid UTF-8", text);
  const bool is_choice =
      field.choices[0].empty() ||
      std::find(field.choices.begin(), field.choices.end(), text) != field.choices.end();
  // The array's empty places are no choices.
  if (!is_choice || (text.empty() && !field.choices[0].empty())) {
    return Wrong(field, "one of " + Choices(field), text);
  }
  return base::JsonString(text);
}

Result<std::string> ParseJsonText(const Field& field, std::string_view raw) {
  const std::string_view text = Trimmed(raw);
  switch (field.type) {
    case FieldType::kInteger:
      if (const auto number = ParseNumber<std::int64_t>(text)) return fmt::format("{}", *number);
      return Wrong(field, "a whole number", raw);
    case FieldType::kNumber:
      if (const auto number = ParseNumber<double>(text); number && std::isfinite(*number)) {
        return fmt::format("{}", *number);
      }
      return Wrong(field, "a number", raw);
    case FieldType::kBoolean:
      for (const std::string_view word : {"true", "false"}) {
        if (base::EqualsIgnoringCase(text, word)) return std::string(word);
      }
      return Wrong(field, "true or false", raw);
    case FieldType::kText:
      return ParseText(field, raw);
    case FieldType::kDateTime:
      if (base::ParseDateTime(text)) return base::JsonString(text);
      return Wrong(field, "a date-time such as 2026-01-02T03:04:05Z", raw);
    case FieldType::kJson: {
      const auto document = base::ParseJson(raw);
      if (document) return base::ToJson(*document);
      return Fail(ErrorKind::kInvalid, fmt::format("{}: {}", field.name, document.error().message));
    }
  }
  return Wrong(field, "known", raw);
}

std::string_view Unquoted(FieldType type) {
  switch (type) {
    case FieldType::kInteger:
      return "a whole number";
    case FieldType::kNumber:
      return "a number";
    case FieldType::kBoolean:
      return "true or false";
    default:
      return "a string";
  }
}

bool Holds(const Field& field, const base::JsonValue& value) {
  switch (field.type) {
    case FieldType::kInteger:
      return value.IsNumber() && value.GetDouble() == std::floor(value.GetDouble());
    case FieldType::kNumber:
      return value.IsNumber();
    case FieldType::kBoolean:
      return value.IsBool();
    case FieldType::kJson:
      return true;
    default:
      return value.IsString();
  }
}

bool Has(const Item& item, std::string_view name) {
  return std::any_of(item.begin(), item.end(), [&](const Member& m) { return m.name == name; });
}

void SortAsTable(std::span<const Field> fields, Item& item) {
  const auto rank = [&](const Member& member) {
    return std::find_if(fields.begin(), fields.end(),
                        [&](const Field& field) { return field.name == member.name; });
  };
  std::stable_sort(item.begin(), item.end(),
                   [&](const Member& a, const Member& b) { return rank(a) < rank(b); });
}

}  // namespace

const Field* FindField(std::span<const Field> fields, std::string_view word) {
  const std::string folded = Folded(word);
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& field) {
    if (Folded(field.name) == folded) return true;
    return !folded.empty() && std::find(field.short_names.begin(), field.short_names.end(),
                                        folded) != field.short_names.end();
  });
  return found == fields.end() ? nullptr : &*found;
}

Result<Member> ParseField(const Field& field, std::string_view text) {
  auto json = ParseJsonText(field, text);
  if (!json) return Fail(std::move(json.error()));
  return Member{std::string(field.name), *std::move(json), std::string(field.parent)};
}

Result<Member> TakeField(const Field& field, const base::JsonValue& value) {
  if (!Holds(field, value)) return Wrong(field, Unquoted(field.type), base::ToJson(value));
  return Member{std::string(field.name), base::ToJson(value), std::string(field.parent)};
}

Result<Item> ItemFrom(std::span<const Field> fields, std::span<const Pair> pairs,
                      Completeness completeness) {
  Item item;
  for (const auto& [key, text] : pairs) {
    const Field* field = FindField(fields, key);
    if (field == nullptr) {
      std::vector<std::string> names;
      for (const Field& each : fields) {
        names.emplace_back(each.short_names[0].empty() ? each.name : each.short_names[0]);
      }
      return Fail(ErrorKind::kInvalid, fmt::format("'{}' is not known here: there are {}",
                                                   base::Printable(key), base::Join(names, ", ")));
    }
    if (Has(item, field->name)) {
      return Fail(ErrorKind::kInvalid, fmt::format("{} is given twice", field->name));
    }
    auto member = ParseField(*field, text);
    if (!member) return Fail(std::move(member.error()));
    item.push_back(*std::move(member));
  }
  if (completeness == Completeness::kWhole) {
    if (auto complete = CheckComplete(fields, item); !complete) return Fail(complete.error());
  }
  SortAsTable(fields, item);
  return item;
}

Result<Item> ParseItem(std::span<const Field> fields, std::string_view text,
                       Completeness completeness) {
  std::vector<Pair> pairs;
  const auto parts = base::Split(text, ',');
  for (const std::string& part : parts) {
    const auto equals = part.find('=');
    if (equals == std::string::npos) {
      return Fail(ErrorKind::kInvalid,
                  fmt::format("'{}' is not a KEY=VALUE, such as lat=50.37", base::Printable(part)));
    }
    const std::string_view view = part;
    pairs.emplace_back(Trimmed(view.substr(0, equals)), view.substr(equals + 1));
  }
  return ItemFrom(fields, pairs, completeness);
}

Status CheckComplete(std::span<const Field> fields, const Item& item) {
  for (const Field& field : fields) {
    if (!field.required || Has(item, field.name)) continue;
    return Fail(ErrorKind::kInvalid, fmt::format("{} is missing", field.name));
  }
  return {};
}

void AddDefaults(const Item& defaults, std::vector<Item>& items) {
  for (Item& item : items) {
    for (const Member& member : defaults) {
      if (!Has(item, member.name)) item.push_back(member);
    }
  }
}

std::string ItemsJson(std::span<const Item> items) {
  std::string json;
  for (const Item& item : items) {
    json += json.empty() ? "{" : ",{";
    for (const Member& member : item) {
      if (json.back() != '{') json += ',';
      json += fmt::format("{}:{}", base::JsonString(member.name), member.json);
    }
    json += '}';
  }
  return "[" + json + "]";
}

}  // namespace fleetpub::soar
