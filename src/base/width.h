// How much room a text takes on a terminal. A person's or robot's name may be Chinese, an emoji, or
// letters with marks of their own: neither bytes nor code points say how many columns that is.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fleetpub::base {

/// Columns that a printable text takes (Printable()); text that is no UTF-8 counts by its bytes.
[[nodiscard]] std::size_t MeasureWidth(std::string_view text);

/// As much of its beginning as fits into so many columns; marks stay with their letter.
[[nodiscard]] std::string_view CutTo(std::size_t width, std::string_view text);

/// The text, or, when it is wider, its beginning and `…`.
[[nodiscard]] std::string Shortened(std::size_t width, std::string_view text);

/// With blanks behind it, so that it takes so many columns at least.
[[nodiscard]] std::string Padded(std::size_t width, std::string_view text);

/// Broken between words into lines of at most so many columns; all but the first begin with `indent`
/// blanks. A word that is wider is cut. Colours (`ESC [ … m`) take no room, and are not cut; nor is a
/// command to type, from `try:` to the end: it is copied as one line.
[[nodiscard]] std::string Wrapped(std::size_t width, std::size_t indent, std::string_view text);

/// Of the library that knows the widths.
[[nodiscard]] std::string_view Utf8procVersion();

}  // namespace fleetpub::base
