// The kinds of values that options take. A kind reads the text, says what it takes instead, and
// lists its choices: for the command line, the environment, the configuration, the help and
// completion alike.
#pragma once

#include <array>
#include <charconv>
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/choice.h"
#include "base/local_time.h"
#include "base/result.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/model/version.h"

namespace fleetpub::cli {

/// What is bound to it must outlive it.
struct ValueKind {
  std::string_view type;  ///< in the help: `TIME`
  /// False: refused, and nothing is stored.
  std::function<bool(const std::vector<std::string>& texts)> store;
  std::function<std::string()> takes = {};  ///< `a duration such as 30s`; empty: its choices
  std::function<std::vector<std::string_view>()> choices = {};
  /// Whether a choice is one in this version; null: in each.
  bool (*exists_in)(std::string_view choice, vda5050::Version version) = nullptr;
  bool is_list = false;

  /// `0, 1 or 2`
  [[nodiscard]] std::string Takes() const;
};

/// The whole text as a number between these.
template <class T>
[[nodiscard]] std::optional<T> ParseBetween(std::string_view text, T least, T most) {
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= least && value <= most)) return {};
  return value;
}

namespace internal {

template <class V>
inline constexpr bool kIsOptional = requires(V value) {
  value.has_value();
};

// An empty text leaves open what may be left open.
template <class V, class Parse>
auto StoreOne(V& value, Parse parse) {
  return [&value, parse](const std::vector<std::string>& texts) {
    if (kIsOptional<V> && texts.front().empty()) return true;
    const auto parsed = parse(texts.front());
    if (parsed) value = *parsed;
    return static_cast<bool>(parsed);
  };
}

template <class V>
struct Stored : std::type_identity<V> {};
template <class T>
struct Stored<std::optional<T>> : std::type_identity<T> {};

}  // namespace internal

[[nodiscard]] ValueKind Text(std::string& value);
[[nodiscard]] ValueKind Text(std::optional<std::string>& value);
/// Repeatable.
[[nodiscard]] ValueKind Text(std::vector<std::string>& values);
[[nodiscard]] ValueKind Flag(bool& value);

/// Milliseconds, or an optional of them; a bare number counts in `unit`.
template <class V>
[[nodiscard]] ValueKind Duration(V& value,
                                 std::chrono::milliseconds unit = std::chrono::seconds(1)) {
  return {
      "TIME",
      internal::StoreOne(value,
                         [unit](const std::string& t) { return base::ParseDuration(t, unit); }),
      [] {
        return std::string("a duration such as 250ms, 30s, 5m, 2h or 90d, of at most ten years");
      }};
}

/// The same kind, but only texts for which `holds` is true; it takes `takes` then.
[[nodiscard]] ValueKind Only(ValueKind kind, bool (*holds)(const std::string& text),
                             std::string takes);

/// A text, or several, none of which is empty, as that of an unset variable of a shell is.
template <class V>
[[nodiscard]] ValueKind Name(V& value) {
  return Only(
      Text(value), [](const std::string& text) { return !text.empty(); },
      "a word that is not empty");
}
/// A file to be written that cannot be standard output.
[[nodiscard]] ValueKind NewFile(std::string& value);

/// A duration that is not 0.
[[nodiscard]] ValueKind Interval(std::chrono::milliseconds& value);

/// A point in time, as protocols or people write it, or a duration before or from now.
[[nodiscard]] ValueKind PointInTime(std::optional<base::WallTime>& value,
                                    base::Direction direction);

/// An integer, or an optional of one; both bounds are included.
template <class V, class T = typename internal::Stored<V>::type>
[[nodiscard]] ValueKind WholeNumber(V& value, std::type_identity_t<T> least = 0,
                                    std::type_identity_t<T> most = std::numeric_limits<T>::max()) {
  return {"N",
          internal::StoreOne(value,
                             [least, most](const std::string& text) {
                               return ParseBetween<T>(text, least, most);
                             }),
          [least, most] {
            return "a whole number from " + std::to_string(least) + " to " + std::to_string(most);
          }};
}

/// A length in metres, or an angle in radians, with other units behind it: `5cm`, `90deg`.
[[nodiscard]] ValueKind Measure(std::optional<double>& value, vda5050::ParameterType type);

/// Messages per second.
[[nodiscard]] ValueKind Rate(std::optional<double>& value);
/// From 0 to 1, written as 0 to 100, with or without %.
[[nodiscard]] ValueKind Percentage(double& value);

/// One of a table, whatever its case. The table must outlive the kind.
template <class V, class T, std::size_t N>
[[nodiscard]] ValueKind OneOf(V& value, const std::array<base::Choice<T>, N>& table) {
  const std::span<const base::Choice<T>> choices = table;
  return {.type = "WORD",
          .store = internal::StoreOne(
              value, [choices](const std::string& t) { return base::ParseChoice(choices, t); }),
          .choices = [choices] {
            std::vector<std::string_view> texts;
            for (std::size_t i = 0; i < choices.size(); ++i) {
              const bool alias = i > 0 && choices[i].value == choices[i - 1].value;
              if (!alias) texts.push_back(choices[i].text);
            }
            return texts;
          }};
}
/// One of these words, stored as it stands there. Empty: none.
[[nodiscard]] ValueKind OneOf(std::string& value, std::span<const std::string_view> words);

enum class Automatic { kNo, kYes };
/// A version of VDA 5050, as it was written; perhaps `auto`. Empty: none.
[[nodiscard]] ValueKind VdaVersion(std::string& value, Automatic automatic = Automatic::kYes);

}  // namespace fleetpub::cli
