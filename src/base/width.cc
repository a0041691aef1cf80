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

std::vector<std::string> Wrapped(std::size_t width, std::string_view text) {
  std::vector<std::string> lines(1);
  std::size_t taken = 0;
  while (!text.empty()) {
    std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    std::size_t columns = MeasureWidth(word);
    if (taken > 0 && columns + 1 > width - std::min(width, taken)) {
      lines.emplace_back();
      taken = 0;
    } else if (taken > 0) {
      lines.back() += ' ';
      ++taken;
    }
    while (columns > width) {
      const std::string_view fitting = CutTo(width, word);
      if (fitting.empty()) break;  // no character is so narrow
      lines.back() += fitting;
      lines.emplace_back();
      word.remove_prefix(fitting.size());
      columns = MeasureWidth(word);
    }
    lines.back() += word;
    taken += columns;
  }
  return lines;
}

std::string_view Utf8procVersion() { return utf8proc_version(); }

}  // namespace fleetpub::base
