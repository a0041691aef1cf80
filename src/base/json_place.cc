#include "base/json_place.h"

#include <algorithm>
#include <charconv>
#include <string>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::base {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

JsonPlace PlaceOf(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto lines = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  const std::size_t newline = before.rfind('\n');
  const std::size_t begin = newline == std::string_view::npos ? 0 : newline + 1;
  return {lines + 1, before.size() - begin + 1};
}

// Walks over a valid text.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) { SkipBlanks(); }

  [[nodiscard]] std::size_t at() const { return at_; }

  // To the value of this member, or this element, of the value at which it stands. Where it begins;
  // nothing when it is not there.
  std::optional<std::size_t> Descend(const std::string& token) {
    const char kind = Now();
    if (kind != '{' && kind != '[') return std::nullopt;
    std::size_t index = 0;
    const auto* const end = token.data() + token.size();
    const bool is_index = std::from_chars(token.data(), end, index).ptr == end && !token.empty();
    for (std::size_t i = 0;; ++i) {
      Step();  // behind the bracket or the comma
      if (Now() == '}' || Now() == ']' || at_ >= text_.size()) return std::nullopt;
      const std::size_t begin = at_;
      bool is_it = kind == '[' && is_index && i == index;
      if (kind == '{') {
        is_it = ReadName() == token;
        Step();  // behind the colon
      }
      if (is_it) return begin;
      SkipValue();
      if (Now() != ',') return std::nullopt;
    }
  }

 private:
  [[nodiscard]] char Now() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void SkipBlanks() { at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size()); }
  void Step() {
    ++at_;
    SkipBlanks();
  }
  void SkipString() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\') ++at_;
    }
    ++at_;
  }
  std::string ReadName() {
    const std::size_t begin = at_;
    SkipString();
    const auto name = ParseJson(text_.substr(begin, at_ - begin));
    SkipBlanks();
    return name && name->IsString() ? std::string(ToView(*name)) : std::string();
  }
  void SkipValue() {
    for (int depth = 0; at_ < text_.size();) {
      const char c = text_[at_];
      if (c == '"') {
        SkipString();
      } else if (c == '{' || c == '[') {
        ++depth;
        ++at_;
      } else if (depth > 0 && (c == '}' || c == ']')) {
        --depth;
        ++at_;
      } else if (depth > 0) {
        ++at_;
        continue;
      } else {
        at_ = std::min(text_.find_first_of(",]} \t\r\n", at_), text_.size());
      }
      if (depth == 0) break;
    }
    SkipBlanks();
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// A reference token without its escapes (RFC 6901 §4).
std::string Unescaped(std::string_view token) {
  std::string name;
  for (std::size_t i = 0; i < token.size(); ++i) {
    const bool is_escape = token[i] == '~' && i + 1 < token.size();
    name += !is_escape ? token[i] : token[++i] == '1' ? '/' : '~';
  }
  return name;
}

}  // namespace

JsonPlace FindPlace(std::string_view json, std::string_view pointer) {
  const std::string_view text = WithoutByteOrderMark(json);
  Walker walker(text);
  std::size_t place = walker.at();
  while (pointer.starts_with('/')) {
    pointer.remove_prefix(1);
    const std::string_view token = pointer.substr(0, pointer.find('/'));
    const auto begin = walker.Descend(Unescaped(token));
    if (!begin) break;
    place = *begin;
    pointer.remove_prefix(token.size());
  }
  return PlaceOf(text, place);
}

std::optional<JsonPlace> FindFault(std::string_view text) {
  text = WithoutByteOrderMark(text);
  rapidjson::MemoryStream stream(text.data(), text.size());
  rapidjson::BaseReaderHandler<> handler;
  JsonReader reader;
  constexpr unsigned kFlags =
      rapidjson::kParseValidateEncodingFlag | rapidjson::kParseIterativeFlag;
  const auto result = reader.Parse<kFlags>(stream, handler);
  if (!result.IsError()) return std::nullopt;
  return PlaceOf(text, result.Offset());
}

}  // namespace fleetpub::base
