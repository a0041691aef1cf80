// A value and the word for it. Tables of them say what an option or a setting may be.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/text.h"

namespace fleetpub::base {

/// Of several words for one value, the first is the one that people are shown.
template <class T>
struct Choice {
  std::string_view text;
  T value;
};

template <class T>
[[nodiscard]] std::optional<T> ParseChoice(std::span<const Choice<T>> choices,
                                           std::string_view text) {
  for (const Choice<T>& choice : choices) {
    if (EqualsIgnoringCase(choice.text, text)) return choice.value;
  }
  return std::nullopt;
}

}  // namespace fleetpub::base
