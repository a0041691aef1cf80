// What the arguments of the process ask for: the subcommand, its options, and the configuration
// beneath them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/parser/arguments.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config.h"

namespace fleetpub::cli {

class CommandLine {
 public:
  GlobalOptions options;
  SubcommandMatch match;
  Run run;  ///< empty: no command was named
  config::Config config;

  /// Once. Errors: kUsage; what could be declared and read by then is there all the same. Only
  /// Extent::kAll knows --help and --version.
  [[nodiscard]] Result<OptionSet::Asked> Read(OptionSet::Extent extent,
                                              const std::vector<std::string>& arguments);

  /// Takes from the configuration what the arguments leave open. Errors: kUsage.
  [[nodiscard]] Status Configure();

  /// With the options of the subcommand that was named, and the global ones.
  [[nodiscard]] const OptionSet& set() const { return *set_; }

 private:
  std::optional<OptionSet> set_;  // the options in it are asked until the end
};

}  // namespace fleetpub::cli
