// Where a subcommand's options are declared, and the only place that sees CLI11.
//
// CLI11 compares each new option with every other one, so that declaring the seventy of a command
// costs more than sending it does. A call therefore declares what its arguments and its environment
// mention, and everything only when somebody needs the whole list: for help, or to say what is
// wrong.
#pragma once

#include <bitset>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/parser/option.h"
#include "config/config.h"

namespace CLI {
class App;
}

namespace fleetpub::cli {

class OptionSet {
 public:
  enum class Extent { kMentioned, kAll };
  enum class Asked { kRun, kBriefHelp, kHelp, kVersion };

  /// `arguments` are all of the process's. --help and --version are known to Extent::kAll only.
  OptionSet(Extent extent, std::span<const std::string> arguments);
  OptionSet(const OptionSet&) = delete;
  OptionSet& operator=(const OptionSet&) = delete;
  ~OptionSet();

  /// `names` as in `-b,--broker`, or a name without dashes for the words that are no options, which
  /// are always declared. Nobody has given an option that is left out. In `help`, {} stands for the
  /// kind's choices.
  Option AddOption(const std::string& names, ValueKind kind, std::string help);
  /// Any text.
  template <class T>
  Option AddOption(const std::string& names, T& value, std::string help) {
    return AddOption(names, Text(value), std::move(help));
  }
  Option AddFlag(const std::string& names, bool& value, const std::string& help);
  /// One that may say more, behind `=` only: `--color=never`. Alone it says `implied`.
  Option AddFlag(const std::string& names, ValueKind kind, std::string implied, std::string help);
  /// What only the configuration sets.
  void AddSetting(std::string_view key, ValueKind kind);

  /// Once. The arguments of this command, without its name. Errors: kUsage.
  [[nodiscard]] Result<Asked> Parse(const std::string& command,
                                    const std::vector<std::string>& arguments);

  /// In the order of their declaration.
  [[nodiscard]] std::vector<Option> options() const;
  /// By a name with its dashes: `--broker`, `-b`. No option, not even IsDeclared, when left out.
  [[nodiscard]] Option Find(const std::string& name) const;
  [[nodiscard]] bool IsDeclared(const std::string& name) const;

  /// Once the arguments are parsed: whether they have the option; not only the environment.
  [[nodiscard]] bool IsByFlag(const std::string& name) const;
  /// Who gave an option that is given: `flag --qos`, `environment variable FLEETPUB_QOS`.
  [[nodiscard]] std::string Origin(const Option& option) const;

  /// Takes from the configuration what nobody gave, but for the keys of `except`: something else was
  /// given instead. The keys that were set. Errors: kUsage.
  [[nodiscard]] Result<std::vector<std::string_view>> Configure(
      const config::Config& config, std::vector<std::string_view> except);

  /// Whether the option that stands for this key takes these texts, which are stored. A key without
  /// an option takes any. Errors: kUsage.
  [[nodiscard]] Status Check(std::string_view key, const std::vector<std::string>& texts) const;

  struct Setting {
    std::string_view key;
    std::vector<std::string> texts;  ///< empty: the default
    std::string origin;              ///< `flag --qos`, `profile north of FILE:3`, `default`
  };
  /// After Configure, all that the configuration may set. What was replaced by something else is
  /// left out.
  [[nodiscard]] std::vector<Setting> Settings(const config::Config& config) const;

 private:
  void Mention(std::string_view argument);
  [[nodiscard]] bool IsMentioned(std::string_view names) const;
  [[nodiscard]] bool IsByFlag(const Option& option) const;
  Option Declare(CLI::Option* option, ValueKind kind);
  [[nodiscard]] std::string FormatGiver(const Option& option) const;
  [[nodiscard]] bool IsExcepted(std::string_view key) const;

  std::unique_ptr<CLI::App> app_;
  bool all_;
  std::set<std::string, std::less<>> long_names_;
  std::bitset<256> letters_;
  mutable std::deque<Option::Record> records_;  ///< which the options point to
  std::optional<Error> refused_;                ///< the first value that its kind does not take
  std::vector<std::string_view> except_;
};

}  // namespace fleetpub::cli
