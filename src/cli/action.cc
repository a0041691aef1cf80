// `fleetpub action TYPE TARGET…`: any instant action, such as a manufacturer's own.
#include <CLI/CLI.hpp>
#include <memory>

#include "cli/sending.h"
#include "cli/subcommand.h"
#include "cli/vda_options.h"

namespace fleetpub::cli {
namespace {

struct Options {
  std::string type;
  InstantOptions instant;
  SendingOptions sending;
};

Result<ExitCode> RunAction(const Options& options, const Context& context) {
  if (options.type.empty()) {
    return Fail(ErrorKind::kUsage, "name the action and the robots: fleetpub action beep KIT/0001");
  }
  const auto commands = BuildCommands(options.instant, options.type, {}, context.output);
  if (!commands) return Fail(commands.error());
  return SendCommands(*commands, options.sending, context);
}

}  // namespace

Run DeclareAction(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("type", options->type, "The actionType, exactly as the robot knows it")
      ->type_name("TYPE");
  DeclareInstantOptions(app, options->instant);
  DeclareSendingOptions(app, options->sending);
  return [options](const Context& context) { return RunAction(*options, context); };
}

}  // namespace fleetpub::cli
