// Where something stands in a JSON text.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::base {

/// Both are counted from 1, the column in bytes.
struct JsonPlace {
  std::size_t line = 1;
  std::size_t column = 1;
};

/// Of what a JSON Pointer names in a valid text: a member where its name begins, an element where
/// its value does. What is not there is said to be where its nearest ancestor is.
[[nodiscard]] JsonPlace FindPlace(std::string_view json, std::string_view pointer);

/// The same of many, in one go over the text.
[[nodiscard]] std::vector<JsonPlace> FindPlaces(std::string_view json,
                                                std::span<const std::string> pointers);

/// From where on a text is no JSON; nothing when it is, or when its grammar is not what is wrong.
[[nodiscard]] std::optional<JsonPlace> FindFault(std::string_view text);

}  // namespace fleetpub::base
