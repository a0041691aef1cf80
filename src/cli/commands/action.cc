// `fleetpub action TYPE TARGET…`: any instant action, such as a manufacturer's own.
#include <memory>

#include "cli/instant_sending.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

struct ActionOptions {
  std::string type;
  InstantSendingOptions sending;
};

Result<ExitCode> RunAction(const ActionOptions& options, const Context& context) {
  if (options.type.empty()) {
    return Fail(ErrorKind::kUsage,
                "name the action and the robots. try: fleetpub action beep KIT/0001");
  }
  return SendInstantAction(options.sending, options.type, {}, context);
}

}  // namespace

Run DeclareAction(OptionSet& set) {
  const auto options = std::make_shared<ActionOptions>();
  set.AddOption("type", options->type, "The actionType, exactly as the robot knows it")
      .Type("TYPE");
  DeclareInstantSendingOptions(set, options->sending);
  return [options](const Context& context) { return RunAction(*options, context); };
}

}  // namespace fleetpub::cli
