#include "base/text.h"

#include <fmt/format.h>
#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace fleetpub::base {
namespace {

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }

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

std::string_view WithoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text;
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

namespace {

struct Stem {
  bool is_negative;
  std::string rest;
};

// The word as it stands, and without a beginning that says yes or no.
std::vector<Stem> FindStems(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, bool>, 11> kBeginnings = {{{"start", false},
                                                                              {"en", false},
                                                                              {"stop", true},
                                                                              {"un", true},
                                                                              {"dis", true},
                                                                              {"de", true},
                                                                              {"no-", true},
                                                                              {"no", true},
                                                                              {"non", true},
                                                                              {"not", true},
                                                                              {"skip", true}}};
  const std::string lower =
      ToLower(word.substr(std::min(word.find_first_not_of('-'), word.size())));
  std::vector<Stem> stems = {{false, lower}};
  for (const auto& [beginning, is_negative] : kBeginnings) {
    if (lower.starts_with(beginning) && lower.size() > beginning.size() + 2) {
      stems.push_back({is_negative, lower.substr(beginning.size())});
    }
  }
  return stems;
}

}  // namespace

bool AreOpposites(std::string_view a, std::string_view b) {
  const int likeness = std::min(2, EditDistance(a, b));
  const auto stems = FindStems(a);
  for (const Stem& other : FindStems(b)) {
    for (const Stem& one : stems) {
      if (one.is_negative != other.is_negative && EditDistance(one.rest, other.rest) < likeness) {
        return true;
      }
    }
  }
  return false;
}

std::optional<std::string> Nearest(std::string_view word,
                                   std::span<const std::string_view> candidates) {
  // A third of the letters may be wrong: `puase` means pause, `fly` means nothing that we have.
  constexpr std::size_t kLongestTypo = 64;
  if (word.size() > kLongestTypo) return std::nullopt;
  std::optional<std::string> nearest;
  bool is_in_doubt = false;
  int least = std::numeric_limits<int>::max();
  for (const std::string_view candidate : candidates) {
    const int distance = EditDistance(word, candidate);
    const auto allowed = static_cast<int>(std::max<std::size_t>(1, word.size() / 3));
    // Not a single letter in common, as in `z` for `x`: another word, not a typo.
    const bool is_other = distance >= static_cast<int>(std::max(word.size(), candidate.size()));
    if (distance > allowed || distance > least || is_other) continue;
    if (distance > 0 && AreOpposites(word, candidate)) continue;
    if (distance < least) {
      least = distance;
      nearest = std::string(candidate);
      is_in_doubt = false;
    } else {
      is_in_doubt = is_in_doubt || AreOpposites(*nearest, candidate);
    }
  }
  return is_in_doubt ? std::nullopt : nearest;
}

CodePoint DecodeFront(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {lead, 1};
  utf8proc_int32_t code = 0;
  const auto bytes = utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                      static_cast<utf8proc_ssize_t>(text.size()), &code);
  if (bytes <= 0) return {};
  return {static_cast<std::uint32_t>(code), static_cast<std::size_t>(bytes)};
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = DecodeFront(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

bool IsHidden(std::uint32_t code) {
  if (code < 0x7F) return code < 0x20;
  const auto& facts = *utf8proc_get_property(static_cast<utf8proc_int32_t>(code));
  switch (facts.category) {
    case UTF8PROC_CATEGORY_CC:
    case UTF8PROC_CATEGORY_CF:
    case UTF8PROC_CATEGORY_CO:
    case UTF8PROC_CATEGORY_ZL:
    case UTF8PROC_CATEGORY_ZP:
      return true;
    default:
      break;
  }
  constexpr std::uint32_t kBlankBraille = 0x2800;
  // Not assigned yet, but to be left out when it is (Other_Default_Ignorable_Code_Point).
  const bool is_reserved =
      code == 0x2065 || (code >= 0xFFF0 && code <= 0xFFF8) || (code >= 0xE0000 && code <= 0xE0FFF);
  return facts.ignorable != 0 || is_reserved || code == kBlankBraille;
}

bool IsBlank(std::uint32_t code) {
  return utf8proc_category(static_cast<utf8proc_int32_t>(code)) == UTF8PROC_CATEGORY_ZS;
}

std::string Printable(std::string_view text) {
  std::string printable;
  printable.reserve(text.size());
  while (!text.empty()) {
    const auto [code, length] = DecodeFront(text);
    if (length == 0) {
      printable += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else if (code == '\n') {
      printable += "\\n";
    } else if (code == '\t') {
      printable += "\\t";
    } else if (code < 0x20 || (code >= 0x7F && code < 0xA0)) {
      printable += fmt::format("\\x{:02x}", code);
    } else if (IsHidden(code)) {
      printable += code > 0xFFFF ? fmt::format("\\U{:08x}", code) : fmt::format("\\u{:04x}", code);
    } else {
      printable += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return printable;
}

}  // namespace fleetpub::base
