#include "base/width.h"

#include <utf8proc.h>

#include <algorithm>

namespace fleetpub::base {
namespace {

struct Glyph {
  std::size_t bytes;
  std::size_t columns;
};

Glyph ReadFront(std::string_view text) {
  if (static_cast<unsigned char>(text.front()) < 0x80) return {1, 1};
  utf8proc_int32_t code = 0;
  const auto bytes = utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                      static_cast<utf8proc_ssize_t>(text.size()), &code);
  if (bytes <= 0) return {1, 1};
  // What is newer than the library's Unicode has no width there; terminals show it all the same.
  const bool is_new = utf8proc_category(code) == UTF8PROC_CATEGORY_CN;
  const auto columns = static_cast<std::size_t>(is_new ? 1 : utf8proc_charwidth(code));
  return {static_cast<std::size_t>(bytes), columns};
}

// Of a word that may be coloured.
std::size_t MeasureColoured(std::string_view word) {
  std::size_t width = 0;
  while (!word.empty()) {
    const std::size_t colour = word.find("\x1b[");
    width += MeasureWidth(word.substr(0, colour));
    if (colour == std::string_view::npos) break;
    const std::size_t end = word.find('m', colour);
    if (end == std::string_view::npos) break;
    word.remove_prefix(end + 1);
  }
  return width;
}

}  // namespace

std::size_t MeasureWidth(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const auto [bytes, columns] = ReadFront(text);
    width += columns;
    text.remove_prefix(bytes);
  }
  return width;
}

std::string_view CutTo(std::size_t width, std::string_view text) {
  std::size_t end = 0;
  while (end < text.size()) {
    const auto [bytes, columns] = ReadFront(text.substr(end));
    if (columns > width) break;
    width -= columns;
    end += bytes;
  }
  return text.substr(0, end);
}

std::string Shortened(std::size_t width, std::string_view text) {
  if (width == 0) return "";
  if (CutTo(width, text).size() == text.size()) return std::string(text);
  return std::string(CutTo(width - 1, text)) + "…";
}

std::string Padded(std::size_t width, std::string_view text) {
  std::string padded(text);
  const std::size_t taken = MeasureWidth(text);
  if (taken < width) padded.append(width - taken, ' ');
  return padded;
}

std::string Wrapped(std::size_t width, std::size_t indent, std::string_view text) {
  std::string lines;
  std::size_t column = 0;
  bool has_word = false;  // in this line
  const auto break_line = [&] {
    lines.append("\n").append(indent, ' ');
    column = indent;
  };
  while (!text.empty()) {
    const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
    const bool is_command = text.substr(begin).starts_with("try: fleetpub ");
    const std::size_t end = std::min(is_command ? text.npos : text.find(' ', begin), text.size());
    std::string_view word = text.substr(begin, end - begin);
    text.remove_prefix(end);
    if (has_word && column + begin + MeasureColoured(word) > width) {
      break_line();
    } else {
      lines.append(begin, ' ');
      column += begin;
    }
    has_word = has_word || !word.empty();
    const bool may_be_cut = !is_command && word.find('\x1b') == std::string_view::npos;
    while (may_be_cut && column + MeasureColoured(word) > width) {
      const std::string_view fitting = CutTo(width - std::min(width, column), word);
      if (fitting.empty()) break;  // no character is so narrow
      lines.append(fitting);
      word.remove_prefix(fitting.size());
      break_line();
    }
    lines.append(word);
    column += MeasureColoured(word);
  }
  return lines;
}

std::string_view Utf8procVersion() { return utf8proc_version(); }

}  // namespace fleetpub::base
