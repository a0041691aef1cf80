// The way of a command from the command line's side: validate, then show it (dry run) or send and
// report it.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "cli/exit_code.h"
#include "cli/global_options.h"
#include "dispatch/command.h"

namespace CLI {
class App;
}

namespace fleetpub::cli {

struct SendingOptions {
  bool dry_run = false;
  std::string qos = "0";
};

void DeclareSendingOptions(CLI::App& app, SendingOptions& options);

/// Sends all of the commands, or none when one of them is invalid. Prints a result for each.
[[nodiscard]] Result<ExitCode> SendCommands(const std::vector<dispatch::Command>& commands,
                                            const SendingOptions& options, const Context& context);

}  // namespace fleetpub::cli
