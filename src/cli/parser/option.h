// One option of the command line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class Option;
}

namespace fleetpub::cli {

/// A handle on an option of a set, or on one of the words without dashes; lives no longer than the
/// set.
class Option {
 public:
  /// No option: nobody gave it, and nothing else may be asked of it.
  Option() = default;
  explicit Option(CLI::Option* option) : option_(option) {}

  // Declaring, in any order.

  /// What stands for its value in the help: `FILE`.
  Option Type(const std::string& name) const;
  /// Its heading in the help.
  Option Group(const std::string& name) const;
  /// The environment variable that gives it: `FLEETPUB_` and the long name in capitals, perhaps
  /// with a word before it (`FLEETPUB_SOAR_SOURCE`).
  Option Variable(const std::string& name) const;
  /// Repeatable, with one value each time: what follows the value is not its own.
  Option OneValueEach() const;
  /// A whole number between these, both included; others are a usage error.
  Option InRange(std::int64_t least, std::int64_t most) const;

  // Asking.

  [[nodiscard]] bool IsGiven() const;
  [[nodiscard]] bool IsPositional() const;
  [[nodiscard]] bool TakesValue() const;
  [[nodiscard]] bool IsRepeatable() const;
  [[nodiscard]] const std::vector<std::string>& short_names() const;  ///< without the dash
  [[nodiscard]] const std::vector<std::string>& long_names() const;   ///< without the dashes
  [[nodiscard]] std::string position_name() const;  ///< of a word without dashes: `target`
  [[nodiscard]] std::string type() const;           ///< `FILE`
  [[nodiscard]] const std::string& group() const;
  [[nodiscard]] const std::string& description() const;
  [[nodiscard]] std::string variable() const;

 private:
  friend class OptionSet;

  CLI::Option* option_ = nullptr;
};

}  // namespace fleetpub::cli
