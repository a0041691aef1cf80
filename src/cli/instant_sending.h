// Sends one instant action to robots: learns how each is spoken to where that is asked, checks it,
// sends, waits.
#pragma once

#include <string_view>
#include <vector>

#include "app/send_command.h"
#include "base/result.h"
#include "cli/options/global_options.h"
#include "cli/options/sending_options.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/options/wait_options.h"
#include "cli/output/exit_code.h"
#include "vda5050/catalogue/parameter.h"

namespace fleetpub::cli {

class OptionSet;

/// Everything that a command for instant actions takes besides its parameters.
struct InstantSendingOptions {
  TargetOptions targets;
  InstantOptions instant;
  SendingOptions sending;
  WaitingOptions waiting;
  bool if_any = false;  ///< of cancelOrder: nothing to cancel is no trouble
  bool force = false;   ///< of initializePosition: several robots may be at one spot
};

void DeclareInstantSendingOptions(OptionSet& set, InstantSendingOptions& options);

/// Prints a result for each robot as it becomes known, and a summary when a word stands for several.
[[nodiscard]] Result<ExitCode> SendToRobots(const app::CommandRequest& request,
                                            const app::SendSettings& settings,
                                            const Context& context, bool no_order_is_fine = false);

[[nodiscard]] Result<ExitCode> SendInstantAction(const InstantSendingOptions& options,
                                                 std::string_view type,
                                                 std::vector<vda5050::Parameter> parameters,
                                                 const Context& context);

}  // namespace fleetpub::cli
