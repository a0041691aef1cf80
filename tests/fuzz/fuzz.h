// What the fuzz targets share. libFuzzer calls LLVMFuzzerTestOneInput() of each with inputs that it
// invents; a target only has to survive them, and Require what must hold for all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace fleetpub::fuzz {

/// Ends the process, for libFuzzer to keep the input, when something that always holds does not.
inline void Require(bool holds) {
  if (!holds) __builtin_trap();
}

inline std::string_view ToText(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// What stands before the first `mark`, and what behind it. Without one, all stands before it.
inline std::pair<std::string_view, std::string_view> Cut(std::string_view text, char mark) {
  const std::size_t place = text.find(mark);
  if (place == std::string_view::npos) return {text, {}};
  return {text.substr(0, place), text.substr(place + 1)};
}

}  // namespace fleetpub::fuzz

/// The body of a target: `FUZZ(text) { … }`.
#define FUZZ(text)                                                                    \
  static void Target(std::string_view text);                                          \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) { \
    Target(fleetpub::fuzz::ToText(data, size));                                       \
    return 0;                                                                         \
  }                                                                                   \
  static void Target(std::string_view text)
