// Small things about text that the standard library lacks.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::base {

[[nodiscard]] std::string ToLower(std::string_view text);  ///< ASCII letters only
[[nodiscard]] bool EqualsIgnoringCase(std::string_view a,
                                      std::string_view b);  ///< ASCII letters only

/// `mapDownloadLink` → `map-download-link`.
[[nodiscard]] std::string ToKebabCase(std::string_view camel);

/// Joins with a separator: `Join({"a", "b"}, ", ")` is `a, b`.
[[nodiscard]] std::string Join(std::span<const std::string> parts, std::string_view separator);
[[nodiscard]] std::vector<std::string> Split(std::string_view text, char separator);

/// Without the blanks, tabs and line ends around it.
[[nodiscard]] std::string_view Trimmed(std::string_view text);

/// The text, or this one where it is empty.
[[nodiscard]] inline std::string_view NonEmptyOr(std::string_view text, std::string_view fallback) {
  return text.empty() ? fallback : text;
}

/// `1 item`, `3 items`.
[[nodiscard]] std::string Counted(std::integral auto count, std::string_view noun) {
  std::string text = std::to_string(count);
  text.append(" ").append(noun);
  if (count != 1) text += 's';
  return text;
}

/// Without the byte order mark that it may begin with.
[[nodiscard]] std::string_view WithoutByteOrderMark(std::string_view text);

/// How many letters must be changed, added, left out or swapped with their neighbour, ignoring
/// case.
[[nodiscard]] int EditDistance(std::string_view a, std::string_view b);

/// Whether two words say the contrary of each other by how they begin, and are alike but for one
/// letter without that: `unpause` and `pause`, `disableMap` and `enableMap`, `stopp` and `start`, `--no-x`.
[[nodiscard]] bool AreOpposites(std::string_view a, std::string_view b);

/// The candidate that the word most probably means, when one is near enough to say so. Never its
/// opposite, and none of two opposites that are equally near.
[[nodiscard]] std::optional<std::string> Nearest(std::string_view word,
                                                 std::span<const std::string_view> candidates);

/// Valid UTF-8 by RFC 3629: no overlong form, no surrogate, nothing above U+10FFFF.
[[nodiscard]] bool IsUtf8(std::string_view text);

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 0;  ///< that it takes in UTF-8; 0: there is none at the front
};

/// The first character of a text that is not empty.
[[nodiscard]] CodePoint DecodeFront(std::string_view text);

/// Whether a person does not see this character, or sees the text around it in another order:
/// control and format characters, line separators, private ones, and all that Unicode lets a
/// display leave out (variation selectors, tags, fillers).
[[nodiscard]] bool IsHidden(std::uint32_t code);

/// A blank of any width (Unicode's Zs).
[[nodiscard]] bool IsBlank(std::uint32_t code);

/// The text made safe for a terminal and for one line: control characters (C0, DEL, C1) and bytes
/// that are no UTF-8 are shown as `\n`, `\x1b`, other hidden characters as `\u202e` or
/// `\U000e0041`. What a robot says must not be able to move an operator's cursor, nor look like
/// another's words.
[[nodiscard]] std::string Printable(std::string_view text);

}  // namespace fleetpub::base
