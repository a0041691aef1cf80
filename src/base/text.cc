#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace fleetpub::base {
namespace {

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }

// The length in bytes of the UTF-8 sequence at the front, 0 when there is none; `code` is its code
// point.
std::size_t DecodeFront(std::string_view text, std::uint32_t& code) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return code = lead, 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  code = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return overlong || surrogate || code > 0x10FFFF ? 0 : length;
}

}  // namespace

std::string ToLower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), Lower);
  return lower;
}

bool EqualsIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return Lower(x) == Lower(y); });
}

std::string ToKebabCase(std::string_view camel) {
  std::string kebab;
  for (const char c : camel) {
    if (IsUpper(c) && !kebab.empty()) kebab += '-';
    kebab += Lower(c);
  }
  return kebab;
}

std::string Join(std::span<const std::string> parts, std::string_view separator) {
  return fmt::format("{}", fmt::join(parts, separator));
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

int EditDistance(std::string_view a, std::string_view b) {
  // Optimal string alignment over three rows.
  std::vector<int> before(b.size() + 1);
  std::vector<int> previous(b.size() + 1);
  std::vector<int> current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const char x = Lower(a[i - 1]);
      const char y = Lower(b[j - 1]);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, previous[j - 1] + (x != y)});
      if (i > 1 && j > 1 && x == Lower(b[j - 2]) && y == Lower(a[i - 2])) {
        current[j] = std::min(current[j], before[j - 2] + 1);
      }
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::optional<std::string> Nearest(std::string_view word,
                                   std::span<const std::string_view> candidates) {
  // A third of the letters may be wrong: `puase` means pause, `fly` means nothing that we have.
  constexpr std::size_t kLongestTypo = 64;
  if (word.size() > kLongestTypo) return std::nullopt;
  std::optional<std::string> nearest;
  int least = std::numeric_limits<int>::max();
  for (const std::string_view candidate : candidates) {
    const int distance = EditDistance(word, candidate);
    const auto allowed = static_cast<int>(std::max<std::size_t>(1, word.size() / 3));
    // Not a single letter in common, as in `z` for `x`: another word, not a typo.
    const bool is_other = distance >= static_cast<int>(std::max(word.size(), candidate.size()));
    if (distance <= allowed && distance < least && !is_other) {
      least = distance;
      nearest = std::string(candidate);
    }
  }
  return nearest;
}

bool IsUtf8(std::string_view text) {
  std::uint32_t code = 0;
  while (!text.empty()) {
    const std::size_t length = DecodeFront(text, code);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

namespace {

// Shows text in another order, or hides in it: marks of direction and what has no width. A name
// would look like another's.
bool IsDeceptive(std::uint32_t code) {
  return code == 0x061C || (code >= 0x200B && code <= 0x200F) ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2060 && code <= 0x2069) || code == 0xFEFF;
}

}  // namespace

std::string Printable(std::string_view text) {
  std::string printable;
  printable.reserve(text.size());
  while (!text.empty()) {
    std::uint32_t code = 0;
    const std::size_t length = DecodeFront(text, code);
    if (length == 0) {
      printable += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else if (code == '\n') {
      printable += "\\n";
    } else if (code == '\t') {
      printable += "\\t";
    } else if (code < 0x20 || (code >= 0x7F && code < 0xA0)) {
      printable += fmt::format("\\x{:02x}", code);
    } else if (IsDeceptive(code)) {
      printable += fmt::format("\\u{:04x}", code);
    } else {
      printable += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return printable;
}

}  // namespace fleetpub::base
