// What a subcommand is: a name, a line of help, options, and something to run.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/output/exit_code.h"

namespace fleetpub::cli {

class OptionSet;

/// Runs once the arguments are parsed.
using Run = std::function<Result<ExitCode>(const Context&)>;

enum class HelpGroup { kRobots, kSoar, kLooking, kChecking };

/// Whether a command runs with the configuration, which must be right then; kExamined: it says itself
/// what is wrong in it, and runs without one that is not right.
enum class ConfigUse { kRead, kExamined, kNone };

struct Subcommand {
  std::string_view name;  ///< `pause`, `schema show`
  HelpGroup group;
  std::string_view arguments;  ///< as the usage line shows them: `TARGET...`
  std::string_view summary;
  std::string_view examples;  ///< lines without the program's name
  /// Adds the options to the App, which is the subcommand's own.
  Run (*declare)(OptionSet& set);
  ConfigUse config = ConfigUse::kRead;
};

/// One per file of this folder.
[[nodiscard]] Run DeclareAction(OptionSet& set);
[[nodiscard]] Run DeclareActions(OptionSet& set);
[[nodiscard]] Run DeclareAwait(OptionSet& set);
[[nodiscard]] Run DeclareBatch(OptionSet& set);
[[nodiscard]] Run DeclareCompletion(OptionSet& set);
[[nodiscard]] Run DeclareConfigCheck(OptionSet& set);
[[nodiscard]] Run DeclareConfigPath(OptionSet& set);
[[nodiscard]] Run DeclareConfigProfiles(OptionSet& set);
[[nodiscard]] Run DeclareConfigInit(OptionSet& set);
[[nodiscard]] Run DeclareConfigShow(OptionSet& set);
[[nodiscard]] Run DeclareConform(OptionSet& set);
[[nodiscard]] Run DeclareDoctor(OptionSet& set);
[[nodiscard]] Run DeclareExplain(OptionSet& set);
[[nodiscard]] Run DeclareFleet(OptionSet& set);
[[nodiscard]] Run DeclareHistory(OptionSet& set);
[[nodiscard]] Run DeclareHistoryPrune(OptionSet& set);
[[nodiscard]] Run DeclareHistoryShow(OptionSet& set);
[[nodiscard]] Run DeclareLayoutCheck(OptionSet& set);
[[nodiscard]] Run DeclareLayoutRoute(OptionSet& set);
[[nodiscard]] Run DeclareLayoutShow(OptionSet& set);
[[nodiscard]] Run DeclareLedgerMigrate(OptionSet& set);
[[nodiscard]] Run DeclareLedgerStatus(OptionSet& set);
[[nodiscard]] Run DeclareOrder(OptionSet& set);
[[nodiscard]] Run DeclareOrderExtend(OptionSet& set);
[[nodiscard]] Run DeclareOrderFollow(OptionSet& set);
[[nodiscard]] Run DeclareOrderRelease(OptionSet& set);
[[nodiscard]] Run DeclareOrderReplace(OptionSet& set);
[[nodiscard]] Run DeclarePing(OptionSet& set);
[[nodiscard]] Run DeclarePublish(OptionSet& set);
[[nodiscard]] Run DeclareRecord(OptionSet& set);
[[nodiscard]] Run DeclareReplay(OptionSet& set);
[[nodiscard]] Run DeclareRequests(OptionSet& set);
[[nodiscard]] Run DeclareRespond(OptionSet& set);
[[nodiscard]] Run DeclareSchemaList(OptionSet& set);
[[nodiscard]] Run DeclareSchemaShow(OptionSet& set);
[[nodiscard]] Run DeclareShow(OptionSet& set);
[[nodiscard]] Run DeclareSimulate(OptionSet& set);
[[nodiscard]] Run DeclareSoarAcknowledge(OptionSet& set);
[[nodiscard]] Run DeclareSoarMissionPlan(OptionSet& set);
[[nodiscard]] Run DeclareSoarObservation(OptionSet& set);
[[nodiscard]] Run DeclareSoarPlanningConfiguration(OptionSet& set);
[[nodiscard]] Run DeclareSoarPlatformStatus(OptionSet& set);
[[nodiscard]] Run DeclareTail(OptionSet& set);
[[nodiscard]] Run DeclareTest(OptionSet& set);
[[nodiscard]] Run DeclareValidate(OptionSet& set);
[[nodiscard]] Run DeclareWatch(OptionSet& set);

/// A command that is a predefined instant action. `word` is what the person called it.
[[nodiscard]] Run DeclareInstantAction(OptionSet& set, std::string_view word);

/// What people call a command beside its name: `status` of `show`. The name itself otherwise.
[[nodiscard]] std::string_view FullName(std::string_view word);

/// Everything but the predefined actions, in the order of the help.
[[nodiscard]] std::span<const Subcommand> Subcommands();

/// In any letter case; null: there is none.
[[nodiscard]] const Subcommand* FindSubcommandNamed(std::string_view name);

/// The first word of several commands, which is none of its own: `schema`.
struct CommandFamily {
  std::string_view name;
  std::string_view summary;
};
/// In any letter case; null: it is none.
[[nodiscard]] const CommandFamily* FindCommandFamily(std::string_view word);

/// What most people need most of the time.
struct EverydayCommand {
  std::string_view title;  ///< of the group: `Look`
  std::string_view name;   ///< `fleet`, `pause`, `config`
  std::string_view arguments;
  std::string_view summary;
};
[[nodiscard]] std::vector<EverydayCommand> EverydayCommands();

}  // namespace fleetpub::cli
