#include "schema/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::schema {
namespace {

using rapidjson::SizeType;
using Value = base::JsonValue;

// 2^63 and 2^64: the doubles from which on an integer no longer fits.
constexpr double kInt64End = 9223372036854775808.0;
constexpr double kUint64End = 18446744073709551616.0;

// The integer that the number is, when one of 64 bits is.
std::optional<Value> AsInteger(const Value& number) {
  if (number.IsInt64() || number.IsUint64()) {
    return number.IsInt64() ? Value(number.GetInt64()) : Value(number.GetUint64());
  }
  const double value = number.GetDouble();
  if (std::trunc(value) != value) return std::nullopt;
  if (value >= -kInt64End && value < kInt64End) return Value(static_cast<std::int64_t>(value));
  if (value >= 0 && value < kUint64End) return Value(static_cast<std::uint64_t>(value));
  return std::nullopt;
}

bool EqualIntegers(const Value& a, const Value& b) {
  if (a.IsInt64() && b.IsInt64()) return a.GetInt64() == b.GetInt64();
  return a.IsUint64() && b.IsUint64() && a.GetUint64() == b.GetUint64();
}

bool EqualNumbers(const Value& a, const Value& b) {
  const auto x = AsInteger(a);
  const auto y = AsInteger(b);
  if (x && y) return EqualIntegers(*x, *y);
  return !x && !y && !(a.GetDouble() < b.GetDouble()) && !(a.GetDouble() > b.GetDouble());
}

bool EqualObjects(const Value& a, const Value& b) {
  if (a.MemberCount() != b.MemberCount()) return false;
  return std::all_of(a.MemberBegin(), a.MemberEnd(), [&b](const auto& member) {
    const auto other = b.FindMember(member.name);
    return other != b.MemberEnd() && Equal(member.value, other->value);
  });
}

void AppendCanonical(const Value& value, std::string& text);

void AppendCanonicalObject(const Value& object, std::string& text) {
  std::vector<const Value::Member*> members;
  members.reserve(object.MemberCount());
  for (const auto& member : object.GetObject()) members.push_back(&member);
  std::sort(members.begin(), members.end(), [](const auto* a, const auto* b) {
    return base::ToView(a->name) < base::ToView(b->name);
  });
  text += '{';
  for (const auto* member : members) {
    text += base::JsonString(base::ToView(member->name));
    text += ':';
    AppendCanonical(member->value, text);
  }
  text += '}';
}

// The same text for two values exactly when they are Equal. Recursion is bounded by
// base::JsonLimits::depth.
void AppendCanonical(const Value& value, std::string& text) {
  if (value.IsObject()) return AppendCanonicalObject(value, text);
  if (value.IsArray()) {
    text += '[';
    for (const Value& item : value.GetArray()) AppendCanonical(item, text);
    text += ']';
  } else if (value.IsNumber()) {
    const auto integer = AsInteger(value);
    text += integer ? base::ToJson(*integer) : fmt::format("{:.17g}", value.GetDouble());
  } else {
    text += base::ToJson(value);
  }
  text += ',';
}

}  // namespace

std::string_view TypeName(const Value& value) {
  constexpr std::array<std::string_view, 7> kNames = {"null",  "boolean", "boolean", "object",
                                                      "array", "string",  "number"};
  return kNames.at(value.GetType());
}

bool IsInteger(const Value& value) {
  if (value.IsInt64() || value.IsUint64()) return true;
  return value.IsDouble() && std::trunc(value.GetDouble()) == value.GetDouble();
}

bool IsOfType(const Value& value, std::string_view type) {
  return type == "integer" ? IsInteger(value) : type == TypeName(value);
}

bool Equal(const Value& a, const Value& b) {
  if (a.IsNumber() && b.IsNumber()) return EqualNumbers(a, b);
  if (a.GetType() != b.GetType()) return false;
  if (a.IsString()) return base::ToView(a) == base::ToView(b);
  if (a.IsObject()) return EqualObjects(a, b);
  if (!a.IsArray()) return true;  // null, true, false
  return std::equal(a.Begin(), a.End(), b.Begin(), b.End(), Equal);
}

std::optional<std::pair<std::size_t, std::size_t>> FirstRepeat(const Value& array) {
  constexpr SizeType kFew = 16;
  if (array.Size() <= kFew) {  // nearly always: comparing pairs beats allocating
    for (SizeType later = 1; later < array.Size(); ++later) {
      for (SizeType earlier = 0; earlier < later; ++earlier) {
        if (Equal(array[earlier], array[later])) return {{earlier, later}};
      }
    }
    return std::nullopt;
  }
  std::vector<std::pair<std::string, std::size_t>> items(array.Size());
  for (SizeType i = 0; i < array.Size(); ++i) {
    AppendCanonical(array[i], items[i].first);
    items[i].second = i;
  }
  std::sort(items.begin(), items.end());
  std::optional<std::pair<std::size_t, std::size_t>> first;
  for (std::size_t i = 1; i < items.size(); ++i) {
    if (items[i - 1].first != items[i].first) continue;
    if (!first || items[i].second < first->second) first = {items[i - 1].second, items[i].second};
  }
  return first;
}

std::uint64_t AsCount(const Value& limit) {
  if (limit.IsUint64()) return limit.GetUint64();
  const double count = limit.GetDouble();
  return count < kUint64End ? static_cast<std::uint64_t>(count)
                            : std::numeric_limits<std::uint64_t>::max();
}

std::uint64_t CountCharacters(std::string_view text) {
  return static_cast<std::uint64_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80;  // not a continuation byte
  }));
}

std::string Shown(const Value& value) {
  if (value.IsObject()) return "an object";
  if (value.IsArray()) return "an array";
  if (value.IsDouble()) return fmt::format("{}", value.GetDouble());
  constexpr std::size_t kLongest = 60;
  std::string text = base::ToJson(value);
  if (text.size() > kLongest) {
    std::size_t end = kLongest - 20;
    while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80) --end;
    text = fmt::format("{}… ({} characters)", text.substr(0, end),
                       value.IsString() ? CountCharacters(base::ToView(value)) : text.size());
  }
  return base::Printable(text);
}

bool IsMultipleOf(const Value& number, const Value& divisor) {
  const auto integer = AsInteger(number);
  const auto by = AsInteger(divisor);
  if (integer && by && integer->IsInt64() && by->IsInt64()) {
    return integer->GetInt64() % by->GetInt64() == 0;
  }
  const double quotient = number.GetDouble() / divisor.GetDouble();
  if (!std::isfinite(quotient)) return false;
  // A decimal fraction is a rounded double: the quotient of two is off by a few units in the last
  // place.
  constexpr double kUnits = 4;
  const double error = std::abs(quotient) * std::numeric_limits<double>::epsilon() * kUnits;
  return std::abs(quotient - std::round(quotient)) <= error;
}

}  // namespace fleetpub::schema
