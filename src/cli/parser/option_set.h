// Where a subcommand's options are declared, and the only place that sees CLI11.
//
// CLI11 compares each new option with every other one, so that declaring the seventy of a command
// costs more than sending it does. A call therefore declares what its arguments and its environment
// mention, and everything only when somebody needs the whole list: for help, or to say what is
// wrong.
#pragma once

#include <bitset>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/parser/config_bindings.h"
#include "cli/parser/option.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fleetpub::cli {

class OptionSet {
 public:
  enum class Extent { kMentioned, kAll };
  enum class Asked { kRun, kHelp, kVersion };

  /// `arguments` are all of the process's. --help and --version are known to Extent::kAll only.
  OptionSet(Extent extent, std::span<const std::string> arguments);
  OptionSet(const OptionSet&) = delete;
  OptionSet& operator=(const OptionSet&) = delete;
  ~OptionSet();

  /// `names` as in `-b,--broker`, or a name without dashes for the words that are no options, which
  /// are always declared. `value` must outlive the set. Nobody has given an option that is left
  /// out.
  template <class T>
  Option AddOption(const std::string& names, T& value, const std::string& help);
  Option AddFlag(const std::string& names, bool& value, const std::string& help);

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

  /// The options that the configuration may set too.
  [[nodiscard]] ConfigBindings& bindings() { return bindings_; }

 private:
  void Mention(std::string_view argument);
  [[nodiscard]] bool IsMentioned(std::string_view names) const;
  [[nodiscard]] bool IsByFlag(const Option& option) const;

  std::unique_ptr<CLI::App> app_;
  bool all_;
  std::set<std::string, std::less<>> long_names_;
  std::bitset<256> letters_;
  std::unique_ptr<CLI::App> unmentioned_;
  CLI::Option* nobody_;  ///< stands for every option that is left out
  ConfigBindings bindings_;
};

}  // namespace fleetpub::cli
