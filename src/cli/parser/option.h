// One option of the command line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/parser/value_kind.h"

namespace CLI {
class Option;
}

namespace fleetpub::cli {

/// A handle on an option of a set, or on one of the words without dashes; lives no longer than the
/// set.
class Option {
 public:
  /// What the set keeps of it.
  struct Record {
    ValueKind kind = {};
    CLI::Option* option = nullptr;  ///< null: left out, so nobody gave it
    std::string_view key = {};
  };

  /// No option.
  Option() = default;
  explicit Option(Record* record) : record_(record) {}

  // Declaring, in any order.

  /// What stands for its value in the help: `FILE`.
  Option Type(std::string_view name) const;
  /// Its heading in the help.
  Option Group(const std::string& name) const;
  /// The environment variable that gives it: `FLEETPUB_` and the long name in capitals, perhaps
  /// with a word before it (`FLEETPUB_SOAR_SOURCE`).
  Option Variable(const std::string& name) const;
  /// Repeatable, with one value each time: what follows the value is not its own.
  Option OneValueEach() const;
  /// The setting of the configuration that stands for it. The key must outlive the set.
  Option Key(std::string_view key) const;

  // Asking.

  [[nodiscard]] bool exists() const { return record_ != nullptr; }
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
  /// As they were given.
  [[nodiscard]] const std::vector<std::string>& texts() const;
  /// Of its kind, those that this version has; without a version all.
  [[nodiscard]] std::vector<std::string_view> Choices(
      std::optional<vda5050::Version> version) const;

  /// Something else was given instead of it.
  void Forget() const;

 private:
  friend class OptionSet;

  Record* record_ = nullptr;
};

}  // namespace fleetpub::cli
