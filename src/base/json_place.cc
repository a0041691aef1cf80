#include "base/json_place.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::base {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

JsonPlace LocateOffset(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto lines = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  const std::size_t newline = before.rfind('\n');
  const std::size_t begin = newline == std::string_view::npos ? 0 : newline + 1;
  return {lines + 1, before.size() - begin + 1};
}

// What pointers name, as a tree.
struct Wanted {
  std::map<std::string, Wanted, std::less<>> below;
  std::vector<std::size_t> pointers;  // that end here

  // What is not there is where its nearest ancestor is.
  void Place(std::size_t offset, std::vector<std::size_t>& offsets) const {
    for (const std::size_t pointer : pointers) offsets[pointer] = offset;
    for (const auto& [token, inner] : below) inner.Place(offset, offsets);
  }
};

// Walks over a valid text.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) { SkipBlanks(); }

  [[nodiscard]] std::size_t at() const { return at_; }

  // Takes what is wanted of the value at which it stands, and goes behind it.
  void Visit(Wanted& wanted, std::vector<std::size_t>& offsets) {
    const char kind = Now();
    if ((kind != '{' && kind != '[') || wanted.below.empty()) return SkipValue();
    for (std::size_t i = 0;; ++i) {
      Step();  // behind the bracket or the comma
      if (Now() == '}' || Now() == ']' || at_ >= text_.size()) break;
      const std::size_t begin = at_;
      std::string token = kind == '{' ? ReadName() : std::to_string(i);
      if (kind == '{') Step();  // behind the colon
      const auto found = wanted.below.find(token);
      if (found == wanted.below.end()) {
        SkipValue();
      } else {
        Wanted below = std::move(found->second);  // of two members of one name the first counts
        wanted.below.erase(found);
        below.Place(begin, offsets);
        Visit(below, offsets);
      }
      if (Now() != ',') break;
    }
    Step();
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

std::vector<JsonPlace> FindPlaces(std::string_view json, std::span<const std::string> pointers) {
  const std::string_view text = WithoutByteOrderMark(json);
  Wanted root;
  for (std::size_t i = 0; i < pointers.size(); ++i) {
    Wanted* wanted = &root;
    std::string_view pointer = pointers[i];
    while (pointer.starts_with('/')) {
      pointer.remove_prefix(1);
      const std::string_view token = pointer.substr(0, pointer.find('/'));
      wanted = &wanted->below[Unescaped(token)];
      pointer.remove_prefix(token.size());
    }
    wanted->pointers.push_back(i);
  }
  Walker walker(text);
  std::vector<std::size_t> offsets(pointers.size());
  root.Place(walker.at(), offsets);
  walker.Visit(root, offsets);

  std::vector<std::size_t> order(pointers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return offsets[a] < offsets[b]; });
  std::vector<JsonPlace> places(pointers.size());
  JsonPlace place;
  std::size_t at = 0;
  for (const std::size_t i : order) {
    for (; at < std::min(offsets[i], text.size()); ++at) {
      place =
          text[at] == '\n' ? JsonPlace{place.line + 1, 1} : JsonPlace{place.line, place.column + 1};
    }
    places[i] = place;
  }
  return places;
}

JsonPlace FindPlace(std::string_view json, std::string_view pointer) {
  return FindPlaces(json, std::vector{std::string(pointer)}).front();
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
  return LocateOffset(text, result.Offset());
}

}  // namespace fleetpub::base
