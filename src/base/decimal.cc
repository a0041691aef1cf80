#include "base/decimal.h"

namespace fleetpub::base {

std::optional<std::string> WithDecimalPoint(std::string_view text) {
  const auto is_digit = [&](std::size_t at) {
    return at < text.size() && text[at] >= '0' && text[at] <= '9';
  };
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos || text.find_first_of(",.", comma + 1) != text.npos ||
      comma == 0 || !is_digit(comma - 1) || !is_digit(comma + 1)) {
    return std::nullopt;
  }
  std::string right(text);
  right[comma] = '.';
  return right;
}

}  // namespace fleetpub::base
