#include "schema/pattern.h"

#include <fmt/format.h>
#include <re2/re2.h>

#include <cctype>
#include <charconv>
#include <cstdint>
#include <string>
#include <utility>

#include "base/text.h"

namespace fleetpub::schema {
namespace {

// What ECMA 262 counts as white space (WhiteSpace and LineTerminator); RE2's \s is ASCII without
// \v.
constexpr std::string_view kSpaces =
    R"(\t\n\v\f\r \x{a0}\x{1680}\x{2000}-\x{200a}\x{2028}\x{2029}\x{202f}\x{205f}\x{3000}\x{feff})";

// The value of exactly four hexadecimal digits at the front, or -1.
std::int32_t FourDigits(std::string_view text) {
  std::int32_t value = -1;
  if (text.size() < 4) return -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + 4, value, 16);
  return error == std::errc() && end == text.data() + 4 ? value : -1;
}

// Writes ECMA 262 escapes as RE2 has them: `\u00e9` as `\x{e9}`, `\s` by its characters, `(?<n>` as
// `(?P<n>`.
class PatternTranslator {
 public:
  explicit PatternTranslator(std::string_view expression) : rest_(expression) {}

  std::string Translate() {
    while (!rest_.empty()) {
      if (rest_.front() == '\\' && rest_.size() > 1) {
        Escape();
      } else if (!in_class_ && rest_.starts_with("[^]")) {
        Take(3, "(?s:.)");
      } else if (!in_class_ && rest_.starts_with("[]")) {
        Take(2, R"([^\x{0}-\x{10ffff}])");
      } else if (!in_class_ && rest_.starts_with("(?<") && rest_.size() > 3 && rest_[3] != '=' &&
                 rest_[3] != '!') {
        Take(3, "(?P<");
      } else {
        if (rest_.front() == '[') in_class_ = true;
        if (rest_.front() == ']') in_class_ = false;
        Take(1, rest_.substr(0, 1));
      }
    }
    return std::move(result_);
  }

 private:
  void Escape() {
    const char kind = rest_[1];
    if (kind == 'u' && FourDigits(rest_.substr(2)) >= 0) return CodePoint();
    if (kind == 's')
      return Take(2, in_class_ ? std::string(kSpaces) : fmt::format("[{}]", kSpaces));
    if (kind == 'S' && !in_class_) return Take(2, fmt::format("[^{}]", kSpaces));
    if (kind == 'c' && rest_.size() > 2 &&
        std::isalpha(static_cast<unsigned char>(rest_[2])) != 0) {
      return Take(3, fmt::format("\\x{{{:x}}}", rest_[2] & 0x1F));
    }
    Take(2, rest_.substr(0, 2));
  }

  void CodePoint() {
    std::int32_t code = FourDigits(rest_.substr(2));
    std::size_t length = 6;
    if (code >= 0xD800 && code < 0xDC00 && rest_.substr(length).starts_with("\\u")) {
      const std::int32_t low = FourDigits(rest_.substr(length + 2));
      if (low >= 0xDC00 && low < 0xE000) {
        code = 0x10000 + (code - 0xD800) * 0x400 + (low - 0xDC00);
        length += 6;
      }
    }
    Take(length, fmt::format("\\x{{{:x}}}", code));
  }

  void Take(std::size_t length, std::string_view replacement) {
    result_ += replacement;
    rest_.remove_prefix(length);
  }

  std::string_view rest_;
  std::string result_;
  bool in_class_ = false;
};

std::string Reason(const re2::RE2& expression) {
  const std::string argument = base::Printable(expression.error_arg());
  if (argument.starts_with("(?")) {
    return fmt::format("looks around with {}, which takes more than linear time", argument);
  }
  if (argument.size() == 2 && argument[0] == '\\' && argument[1] >= '1' && argument[1] <= '9') {
    return fmt::format("refers back with {}, which takes more than linear time", argument);
  }
  switch (expression.error_code()) {
    case re2::RE2::ErrorMissingParen:
    case re2::RE2::ErrorUnexpectedParen:
      return "has a ( without a ), or the other way round";
    case re2::RE2::ErrorMissingBracket:
      return "has a [ without a ]";
    case re2::RE2::ErrorRepeatArgument:
    case re2::RE2::ErrorRepeatOp:
      return fmt::format("repeats nothing with {}", argument);
    case re2::RE2::ErrorRepeatSize:
      return fmt::format("repeats more often than is possible here: {}", argument);
    case re2::RE2::ErrorPatternTooLarge:
      return "is too large";
    default:
      return fmt::format("has a part that cannot be read: {}", argument);
  }
}

}  // namespace

Pattern::Pattern(std::unique_ptr<re2::RE2> expression) : expression_(std::move(expression)) {}
Pattern::Pattern(Pattern&&) noexcept = default;
Pattern& Pattern::operator=(Pattern&&) noexcept = default;
Pattern::~Pattern() = default;

Result<Pattern> Pattern::Compile(std::string_view expression) {
  re2::RE2::Options options(re2::RE2::Quiet);
  auto compiled = std::make_unique<re2::RE2>(PatternTranslator(expression).Translate(), options);
  if (!compiled->ok()) return Fail(ErrorKind::kInvalid, Reason(*compiled));
  return Pattern(std::move(compiled));
}

bool Pattern::Matches(std::string_view text) const {
  return re2::RE2::PartialMatch(re2::StringPiece(text.data(), text.size()), *expression_);
}

}  // namespace fleetpub::schema
