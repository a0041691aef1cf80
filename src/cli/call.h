// What the arguments of the process ask for: the subcommand, its options, and the configuration
// beneath them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "cli/arguments.h"
#include "cli/config.h"
#include "cli/global_options.h"
#include "cli/option_set.h"
#include "cli/subcommand.h"

namespace fleetpub::cli {

class Call {
 public:
  Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  ~Call();

  GlobalOptions options;
  Invocation invocation;
  Run run;  ///< empty: no command was named
  Config config;

  /// Once. Errors: kUsage; what could be declared and read by then is there all the same. Throws
  /// CLI::Success for --help and --version, which only Extent::kAll knows.
  [[nodiscard]] Status Read(OptionSet::Extent extent, const std::vector<std::string>& arguments);

  /// Takes from the configuration what the arguments leave open. Errors: kUsage.
  [[nodiscard]] Status Configure();

  /// With the options of the subcommand that was named, and the global ones.
  [[nodiscard]] const CLI::App& app() const { return *app_; }

 private:
  std::unique_ptr<CLI::App> app_;
  std::optional<OptionSet> set_;  // the options in it are asked until the end
};

}  // namespace fleetpub::cli
