// Numbers as people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fleetpub::base {

/// `1.5` of `1,5`; nothing where there is no single comma between digits.
[[nodiscard]] std::optional<std::string> WithDecimalPoint(std::string_view text);

}  // namespace fleetpub::base
