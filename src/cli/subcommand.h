// What a subcommand is: a name, a line of help, options, and something to run.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/exit_code.h"
#include "cli/global_options.h"

namespace CLI {
class App;
}

namespace fleetpub::cli {

/// Runs once the arguments are parsed.
using Run = std::function<Result<ExitCode>(const Context&)>;

enum class HelpGroup { kRobots, kSoar, kLooking, kChecking };

struct Subcommand {
  std::string_view name;  ///< `pause`, `schema show`
  HelpGroup group;
  std::string_view arguments;  ///< as the usage line shows them: `TARGET...`
  std::string_view summary;
  std::string_view examples;  ///< lines without the program's name
  /// Adds the options to the App, which is the subcommand's own.
  Run (*declare)(CLI::App& app);
};

/// One per file of this folder.
[[nodiscard]] Run DeclareAction(CLI::App& app);
[[nodiscard]] Run DeclareActions(CLI::App& app);
[[nodiscard]] Run DeclareAwait(CLI::App& app);
[[nodiscard]] Run DeclareFleet(CLI::App& app);
[[nodiscard]] Run DeclareHistory(CLI::App& app);
[[nodiscard]] Run DeclareHistoryPrune(CLI::App& app);
[[nodiscard]] Run DeclareHistoryShow(CLI::App& app);
[[nodiscard]] Run DeclarePing(CLI::App& app);
[[nodiscard]] Run DeclareSchemaList(CLI::App& app);
[[nodiscard]] Run DeclareSchemaShow(CLI::App& app);
[[nodiscard]] Run DeclareSimulate(CLI::App& app);
[[nodiscard]] Run DeclareSoarAcknowledge(CLI::App& app);
[[nodiscard]] Run DeclareSoarMissionPlan(CLI::App& app);
[[nodiscard]] Run DeclareSoarObservation(CLI::App& app);
[[nodiscard]] Run DeclareSoarPlanningConfiguration(CLI::App& app);
[[nodiscard]] Run DeclareSoarPlatformStatus(CLI::App& app);
[[nodiscard]] Run DeclareValidate(CLI::App& app);
[[nodiscard]] Run DeclareWatch(CLI::App& app);

/// A command that is a predefined instant action. `word` is what the person called it.
[[nodiscard]] Run DeclareInstantAction(CLI::App& app, std::string_view word);

/// Everything but the predefined actions, in the order of the help.
[[nodiscard]] std::span<const Subcommand> Subcommands();

}  // namespace fleetpub::cli
