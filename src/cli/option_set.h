// Where a subcommand's options are declared.
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

#include "cli/config_bindings.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fleetpub::cli {

class OptionSet {
 public:
  enum class Extent { kMentioned, kAll };

  /// Over the App, which must outlive the set. `arguments` are all of the process's.
  OptionSet(CLI::App& app, Extent extent, std::span<const std::string> arguments);
  OptionSet(const OptionSet&) = delete;
  OptionSet& operator=(const OptionSet&) = delete;
  ~OptionSet();

  /// As CLI::App::add_option: `-b,--broker`, or a name without dashes for the words that are no
  /// options, which are always declared. An option's environment variable is `FLEETPUB_` and its
  /// long name in capitals, perhaps with a word before it (`FLEETPUB_SOAR_SOURCE`). The result may
  /// be passed to CLI11 only; it is empty when nobody gave the option, and lives no longer than the
  /// set.
  template <class T>
  CLI::Option* AddOption(const std::string& names, T& value, const std::string& help);
  CLI::Option* AddFlag(const std::string& names, bool& value, const std::string& help);

  /// Once the arguments are parsed: whether they have the option, of this name with its dashes; not
  /// only the environment.
  [[nodiscard]] bool IsByFlag(const std::string& name) const;

  /// The options that the configuration may set too.
  [[nodiscard]] ConfigBindings& bindings() { return bindings_; }
  [[nodiscard]] const CLI::App& app() const { return app_; }

 private:
  void Mention(std::string_view argument);
  [[nodiscard]] bool IsMentioned(std::string_view names) const;

  CLI::App& app_;
  bool all_;
  std::set<std::string, std::less<>> long_names_;
  std::bitset<256> letters_;
  std::unique_ptr<CLI::App> unmentioned_;
  CLI::Option* nobody_;  ///< stands for every option that is left out
  ConfigBindings bindings_;
};

}  // namespace fleetpub::cli
