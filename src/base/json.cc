#include "base/json.h"

#include <fmt/format.h>
#include <rapidjson/error/error.h>
#include <rapidjson/memorystream.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/text.h"

namespace fleetpub::base {
namespace {

// RapidJSON's own reading of numbers is not used: it makes 1.9e22 of `0e41`, and reads beyond its
// table at very small ones.
constexpr unsigned kParseFlags =
    rapidjson::kParseIterativeFlag | rapidjson::kParseNumbersAsStringsFlag;

// Most messages are, and RapidJSON looks at each byte by itself to see that a text is UTF-8.
bool IsAscii(std::string_view text) {
  std::uint64_t bits = 0;
  for (; text.size() >= sizeof(bits); text.remove_prefix(sizeof(bits))) {
    std::uint64_t some = 0;
    std::memcpy(&some, text.data(), sizeof(some));
    bits |= some;
  }
  for (const char c : text) bits |= static_cast<unsigned char>(c);
  constexpr std::uint64_t kHighBits = 0x8080808080808080;
  return (bits & kHighBits) == 0;
}

// RapidJSON decodes an escaped low surrogate that has no high one before it (`"\uDC00"`) to bytes
// that are no UTF-8: ED A0..BF.
bool HoldsSurrogate(std::string_view text) {
  for (auto at = text.find('\xED'); at != std::string_view::npos; at = text.find('\xED', at + 1)) {
    if (at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) >= 0xA0) return true;
  }
  return false;
}

// The nearest double; too small a number is 0. Nothing when it is too large for one.
std::optional<double> ReadDouble(std::string_view text) {
  double value = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc()) {
    return value;
  }
  value = std::strtod(std::string(text).c_str(), nullptr);  // tells too large from too small
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// Passes every event on to the document and stops the parser at the first one too deep, at a text
// that is none, and at a number that no double can hold.
class Guard {
 public:
  using Ch = char;

  Guard(JsonDocument& document, int limit, bool exact)
      : document_(document), limit_(limit), exact_(exact) {}

  bool Null() { return document_.Null(); }
  bool Bool(bool value) { return document_.Bool(value); }
  bool Int(int value) { return document_.Int(value); }
  bool Uint(unsigned value) { return document_.Uint(value); }
  bool Int64(int64_t value) { return document_.Int64(value); }
  bool Uint64(uint64_t value) { return document_.Uint64(value); }
  bool Double(double value) { return document_.Double(value); }
  bool RawNumber(const char* text, rapidjson::SizeType length, bool /*copy*/) {
    const std::string_view number(text, length);
    if (number.find_first_of(".eE") == std::string_view::npos) {
      if (int64_t value = 0; ReadWhole(number, value)) return document_.Int64(value);
      if (uint64_t value = 0; ReadWhole(number, value)) return document_.Uint64(value);
      inexact_ = exact_;
      if (inexact_) return false;
    }
    const auto value = ReadDouble(number);
    too_large_ = !value;
    return value && document_.Double(*value);
  }
  bool String(const char* text, rapidjson::SizeType length, bool copy) {
    return IsText(text, length) && document_.String(text, length, copy);
  }
  bool Key(const char* text, rapidjson::SizeType length, bool copy) {
    return IsText(text, length) && document_.Key(text, length, copy);
  }
  bool StartObject() { return Enter() && document_.StartObject(); }
  bool EndObject(rapidjson::SizeType members) { return Leave(), document_.EndObject(members); }
  bool StartArray() { return Enter() && document_.StartArray(); }
  bool EndArray(rapidjson::SizeType elements) { return Leave(), document_.EndArray(elements); }

  [[nodiscard]] bool too_deep() const { return depth_ > limit_; }
  [[nodiscard]] bool too_large() const { return too_large_; }
  [[nodiscard]] bool inexact() const { return inexact_; }

 private:
  template <typename Whole>
  static bool ReadWhole(std::string_view text, Whole& value) {
    return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
  }
  bool Enter() { return ++depth_ <= limit_; }
  void Leave() { --depth_; }
  static bool IsText(const char* text, rapidjson::SizeType length) {
    return !HoldsSurrogate({text, length});
  }

  JsonDocument& document_;
  int limit_;
  bool exact_;
  int depth_ = 0;
  bool too_large_ = false;
  bool inexact_ = false;
};

// Feeds a Document from a text: JsonDocument::Populate calls it with the document as
// handler.
struct Generator {
  std::string_view text;
  int depth;
  bool exact = false;
  rapidjson::ParseResult result = {};
  bool too_deep = false;
  bool too_large = false;
  bool inexact = false;

  bool operator()(JsonDocument& document) {
    JsonReader reader;
    Guard guard(document, depth, exact);
    rapidjson::MemoryStream stream(text.data(), text.size());
    result = IsAscii(text)
                 ? reader.Parse<kParseFlags>(stream, guard)
                 : reader.Parse<kParseFlags | rapidjson::kParseValidateEncodingFlag>(stream, guard);
    too_deep = guard.too_deep();
    too_large = guard.too_large();
    inexact = guard.inexact();
    return !result.IsError();
  }
};

std::string Place(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t newline = before.rfind('\n');
  const std::size_t column =
      before.size() - (newline == std::string_view::npos ? 0 : newline + 1) + 1;
  return fmt::format("line {}, column {}", line, column);
}

// In our words, not RapidJSON's.
std::string_view WordsFor(rapidjson::ParseErrorCode code) {
  switch (code) {
    case rapidjson::kParseErrorDocumentEmpty:
      return "nothing is there";
    case rapidjson::kParseErrorDocumentRootNotSingular:
      return "something follows after its end";
    case rapidjson::kParseErrorValueInvalid:
      return "a value is expected here: write a text in quotation marks";
    case rapidjson::kParseErrorObjectMissName:
      return "a member's name in quotation marks is expected here (is there a comma too many?)";
    case rapidjson::kParseErrorObjectMissColon:
      return "a colon is missing after a member's name";
    case rapidjson::kParseErrorObjectMissCommaOrCurlyBracket:
      return "a comma or } is missing";
    case rapidjson::kParseErrorArrayMissCommaOrSquareBracket:
      return "a comma or ] is missing";
    case rapidjson::kParseErrorStringUnicodeEscapeInvalidHex:
      return "four hexadecimal digits are missing after \\u";
    case rapidjson::kParseErrorStringUnicodeSurrogateInvalid:
      return "half of a surrogate pair";
    case rapidjson::kParseErrorStringEscapeInvalid:
      return "an escape that JSON does not have";
    case rapidjson::kParseErrorStringMissQuotationMark:
      return "a quotation mark is missing";
    case rapidjson::kParseErrorStringInvalidEncoding:
      return "not UTF-8";
    case rapidjson::kParseErrorNumberTooBig:
      return "a number is too large";
    case rapidjson::kParseErrorNumberMissFraction:
      return "digits are missing after the decimal point";
    case rapidjson::kParseErrorNumberMissExponent:
      return "digits are missing in the exponent";
    default:
      return "it cannot be read from here on";
  }
}

Error ParseError(std::string_view text, const Generator& generator) {
  const std::string place = Place(text, generator.result.Offset());
  if (generator.too_deep) {
    return {ErrorKind::kInvalid, fmt::format("not accepted at {}: nested more than {} levels deep",
                                             place, generator.depth)};
  }
  if (generator.inexact) {
    return {ErrorKind::kInvalid,
            fmt::format("not accepted at {}: a whole number of more than 64 bits would be sent as "
                        "another one: write a text, or an exponent (1.5e22)",
                        place)};
  }
  const bool by_guard = generator.result.Code() == rapidjson::kParseErrorTermination;
  const auto refused = generator.too_large ? rapidjson::kParseErrorNumberTooBig
                                           : rapidjson::kParseErrorStringUnicodeSurrogateInvalid;
  const auto code = by_guard ? refused : generator.result.Code();
  const std::string_view rest = text.substr(std::min(generator.result.Offset(), text.size()));
  if (!by_guard && code != rapidjson::kParseErrorDocumentEmpty &&
      rest.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    return {ErrorKind::kInvalid,
            fmt::format("not valid JSON at {}: the text ends before it is complete", place)};
  }
  return {ErrorKind::kInvalid, fmt::format("not valid JSON at {}: {}", place, WordsFor(code))};
}

// The name that stands twice in this object, or null.
const JsonValue* RepeatedName(const JsonValue& object) {
  const auto begin = object.MemberBegin();
  const auto end = object.MemberEnd();
  constexpr rapidjson::SizeType kFew = 16;
  if (object.MemberCount() <= kFew) {  // nearly always: comparing pairs beats allocating
    for (auto a = begin; a != end; ++a) {
      for (auto b = begin; b != a; ++b) {
        if (ToView(a->name) == ToView(b->name)) return &a->name;
      }
    }
    return nullptr;
  }
  std::vector<const JsonValue*> names;
  names.reserve(object.MemberCount());
  for (auto it = begin; it != end; ++it) names.push_back(&it->name);
  std::sort(names.begin(), names.end(),
            [](const auto* a, const auto* b) { return ToView(*a) < ToView(*b); });
  const auto twice =
      std::adjacent_find(names.begin(), names.end(),
                         [](const auto* a, const auto* b) { return ToView(*a) == ToView(*b); });
  return twice == names.end() ? nullptr : *twice;
}

// The pointer to the first repeated name below `value`, or "". Recursion is bounded by
// JsonLimits::depth.
std::string FindRepeatedName(const JsonValue& value) {
  if (value.IsObject()) {
    if (const auto* name = RepeatedName(value)) return "/" + PointerToken(ToView(*name));
    for (const auto& member : value.GetObject()) {
      if (!member.value.IsObject() && !member.value.IsArray()) continue;
      std::string below = FindRepeatedName(member.value);
      if (!below.empty()) return "/" + PointerToken(ToView(member.name)) + below;
    }
  } else if (value.IsArray()) {
    for (rapidjson::SizeType i = 0; i < value.Size(); ++i) {
      if (!value[i].IsObject() && !value[i].IsArray()) continue;
      std::string below = FindRepeatedName(value[i]);
      if (!below.empty()) return fmt::format("/{}{}", i, below);
    }
  }
  return {};
}

// ── reading leniently ──

// The UTF-16 unit of an escape `\uXXXX` at the front; 0 when there is none.
std::uint32_t EscapedUnit(std::string_view text) {
  constexpr std::size_t kLength = 6;
  std::uint32_t unit = 0;
  if (text.size() < kLength || !text.starts_with("\\u")) return 0;
  const char* const end = text.data() + kLength;
  return std::from_chars(text.data() + 2, end, unit, 16).ptr == end ? unit : 0;
}

// Moves one character or escape of a text.
void MoveCharacter(std::string_view& from, std::string& to) {
  constexpr std::string_view kReplacement = "\\ufffd";
  const auto take = [&](std::size_t bytes) {
    to += from.substr(0, bytes);
    from.remove_prefix(std::min(bytes, from.size()));
  };
  if (from.front() == '\\') {
    const std::uint32_t unit = EscapedUnit(from);
    const bool is_half = unit >= 0xD800 && unit <= 0xDFFF;
    if (!is_half) return take(2);
    const bool is_pair = unit < 0xDC00 && EscapedUnit(from.substr(6)) >> 10U == 0x37;
    if (is_pair) return take(12);
    to += kReplacement;
    from.remove_prefix(6);
  } else if (static_cast<unsigned char>(from.front()) < 0x20) {
    to += fmt::format("\\u{:04x}", from.front());
    from.remove_prefix(1);
  } else if (const std::size_t bytes = DecodeFront(from).bytes; bytes > 0) {
    take(bytes);
  } else {
    to += kReplacement;
    from.remove_prefix(1);
  }
}

// Moves a word that stands outside of texts: `NaN` and `-inf` become null.
void MoveWord(std::string_view& from, std::string& to) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto* const end = std::find_if_not(from.begin(), from.end(), is_letter);
  const auto length = std::max<std::size_t>(1, static_cast<std::size_t>(end - from.begin()));
  const std::string_view word = from.substr(0, length);
  from.remove_prefix(length);
  const bool is_no_number = EqualsIgnoringCase(word, "nan") || EqualsIgnoringCase(word, "inf") ||
                            EqualsIgnoringCase(word, "infinity");
  if (is_no_number && (to.ends_with('-') || to.ends_with('+'))) to.pop_back();
  to += is_no_number ? "null" : word;
}

std::string Repaired(std::string_view text) {
  text = WithoutByteOrderMark(text);
  constexpr std::string_view kBehind("\0 \t\r\n", 5);
  text = text.substr(0, text.find_last_not_of(kBehind) + 1);
  std::string repaired;
  repaired.reserve(text.size());
  bool is_inside = false;
  while (!text.empty()) {
    const char c = text.front();
    if (c == '"') {
      is_inside = !is_inside;
      repaired += c;
      text.remove_prefix(1);
    } else {
      is_inside ? MoveCharacter(text, repaired) : MoveWord(text, repaired);
    }
  }
  return repaired;
}

// Recursion is bounded by JsonLimits::depth.
void KeepLastOfEachName(JsonValue& value, JsonPool& pool) {
  if (value.IsArray()) {
    for (JsonValue& element : value.GetArray()) KeepLastOfEachName(element, pool);
  }
  if (!value.IsObject()) return;
  std::unordered_set<std::string_view> names;
  std::vector<bool> is_last(value.MemberCount());
  for (std::size_t i = is_last.size(); i > 0; --i) {
    const auto member = value.MemberBegin() + static_cast<std::ptrdiff_t>(i - 1);
    is_last[i - 1] = names.insert(ToView(member->name)).second;
    KeepLastOfEachName(member->value, pool);
  }
  if (names.size() == is_last.size()) return;
  JsonValue kept(rapidjson::kObjectType);
  for (std::size_t i = 0; i < is_last.size(); ++i) {
    const auto member = value.MemberBegin() + static_cast<std::ptrdiff_t>(i);
    if (is_last[i]) kept.AddMember(member->name, member->value, pool);
  }
  value = kept;  // moves
}

}  // namespace

Result<JsonDocument> ParseJsonLeniently(std::string_view text, JsonLimits limits) {
  auto strict = ParseJson(text, limits);
  if (strict || text.size() > limits.bytes) return strict;
  const std::string repaired = Repaired(text);
  JsonDocument document;
  Generator generator{.text = repaired, .depth = limits.depth, .exact = limits.exact};
  document.Populate(generator);
  if (generator.result.IsError()) return Fail(ParseError(repaired, generator));
  KeepLastOfEachName(document, document.GetAllocator());
  return document;
}

Result<JsonDocument> ParseJson(std::string_view text, JsonLimits limits) {
  if (text.size() > limits.bytes) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("too large: {} bytes, at most {} are read", text.size(), limits.bytes));
  }
  text = WithoutByteOrderMark(text);
  if (const auto nul = text.find('\0'); nul != std::string_view::npos) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("not valid JSON at {}: a NUL byte", Place(text, nul)));
  }
  JsonDocument document;
  Generator generator{.text = text, .depth = limits.depth, .exact = limits.exact};
  document.Populate(generator);
  if (generator.result.IsError()) return Fail(ParseError(text, generator));
  if (const std::string name = FindRepeatedName(document); !name.empty()) {
    return Fail(ErrorKind::kInvalid, fmt::format("{} appears twice", name));
  }
  return document;
}

std::string ToJson(const JsonValue& value) {
  JsonBuffer buffer;
  JsonWriter writer(buffer);
  value.Accept(writer);
  return {buffer.GetString(), buffer.GetSize()};
}

std::string ToPrettyJson(const JsonValue& value) {
  JsonBuffer buffer;
  JsonPrettyWriter writer(buffer);
  writer.SetIndent(' ', 2);
  value.Accept(writer);
  return {buffer.GetString(), buffer.GetSize()};
}

std::string ShownJson(std::string_view json) {
  const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x7F; };
  std::string shown;
  shown.reserve(json.size());
  for (;;) {
    const auto* const end = std::find_if_not(json.begin(), json.end(), is_ascii);
    shown.append(json.begin(), end);
    json.remove_prefix(static_cast<std::size_t>(end - json.begin()));
    if (json.empty()) return shown;
    const auto [code, bytes] = DecodeFront(json);
    if (bytes == 0) {
      shown += "\\ufffd";
    } else if (!IsHidden(code)) {
      shown += json.substr(0, bytes);
    } else if (code <= 0xFFFF) {
      shown += fmt::format("\\u{:04x}", code);
    } else {
      const std::uint32_t rest = code - 0x10000;
      shown += fmt::format("\\u{:04x}\\u{:04x}", 0xD800 + (rest >> 10), 0xDC00 + (rest & 0x3FF));
    }
    json.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
}

std::string JsonString(std::string_view text) {
  const bool is_plain = std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\';
  });
  if (is_plain) {  // nearly always, and a dozen times per message
    std::string quoted;
    quoted.reserve(text.size() + 2);
    quoted += '"';
    quoted += text;
    return quoted += '"';
  }
  JsonBuffer buffer;
  JsonWriter writer(buffer);
  writer.String(text.data(), static_cast<rapidjson::SizeType>(text.size()));
  return {buffer.GetString(), buffer.GetSize()};
}

std::string_view StringMember(const JsonValue& object, std::string_view name) {
  const JsonValue* member = FindMember(object, name);
  return member != nullptr && member->IsString() ? ToView(*member) : std::string_view();
}

std::optional<std::uint32_t> UintMember(const JsonValue& object, std::string_view name) {
  const JsonValue* member = FindMember(object, name);
  if (member == nullptr || !member->IsUint()) return std::nullopt;
  return member->GetUint();
}

std::optional<double> NumberMember(const JsonValue& object, std::string_view name) {
  const JsonValue* member = FindMember(object, name);
  if (member == nullptr || !member->IsNumber()) return std::nullopt;
  return member->GetDouble();
}

bool IsTrueMember(const JsonValue& object, std::string_view name) {
  const JsonValue* member = FindMember(object, name);
  return member != nullptr && member->IsTrue();
}

const JsonValue* FindMember(const JsonValue& value, std::string_view name) {
  if (!value.IsObject()) return nullptr;
  const JsonValue key(
      rapidjson::StringRef(name.data(), static_cast<rapidjson::SizeType>(name.size())));
  const auto it = value.FindMember(key);
  return it == value.MemberEnd() ? nullptr : &it->value;
}

const JsonValue* FindArray(const JsonValue& value, std::string_view name) {
  const JsonValue* member = FindMember(value, name);
  return member != nullptr && member->IsArray() ? member : nullptr;
}

void RenameMember(JsonDocument& document, std::string_view from, std::string_view to) {
  if (!document.IsObject()) return;
  const auto end = document.MemberEnd();
  for (auto it = document.MemberBegin(); it < end; ++it) {
    if (ToView(it->name) != from) continue;
    it->name.SetString(to.data(), static_cast<rapidjson::SizeType>(to.size()),
                       document.GetAllocator());
  }
}

std::string PointerToken(std::string_view name) {
  std::string token;
  token.reserve(name.size());
  for (const char c : name) {
    if (c == '~') {
      token += "~0";
    } else if (c == '/') {
      token += "~1";
    } else {
      token += c;
    }
  }
  return token;
}

}  // namespace fleetpub::base
