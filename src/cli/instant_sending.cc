#include "cli/instant_sending.h"

#include <memory>

#include "app/send_command.h"
#include "cli/environment.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {

void DeclareInstantSendingOptions(OptionSet& set, InstantSendingOptions& options) {
  DeclareTargetOptions(set, options.targets);
  DeclareInstantOptions(set, options.instant);
  DeclareSendingOptions(set, options.sending);
  DeclareManyOptions(set, options.sending);
  DeclareWaitingOptions(set, options.waiting);
  DeclareVdaOptions(set, options.instant.vda);
}

Result<ExitCode> SendToRobots(const app::CommandRequest& request, const app::SendSettings& settings,
                              const Context& context, bool no_order_is_fine) {
  using Show = SendingObserver::Show;
  SendingObserver observer(context.output,
                           settings.dry_run          ? Show::kPayloads
                           : request.targets.IsSet() ? Show::kResultsAndProgress
                                                     : Show::kResults,
                           FormatSite(context), no_order_is_fine);
  auto sent = app::SendCommand(request, settings, MakeEnvironment(context), observer);
  if (!sent) return Fail(std::move(sent.error()));
  return observer.Conclude();
}

namespace {

// Two robots that are told the same position collide, or believe to have.
Status CheckOneSpot(const InstantSendingOptions& options, std::string_view type,
                    const app::Targets& targets) {
  const bool is_position = vda5050::ActionCalled(type) == vda5050::ActionCalled("initPosition");
  const bool may_be_many =
      targets.AreFound() ? targets.expect.value_or(2) > 1 : targets.include.robots.size() > 1;
  if (!is_position || !may_be_many || options.force || options.sending.dry_run) return {};
  return Fail(
      ErrorKind::kUsage,
      "nothing was sent: several robots cannot be at one position: name one robot, or add --force");
}

}  // namespace

Result<ExitCode> SendInstantAction(const InstantSendingOptions& options, std::string_view type,
                                   std::vector<vda5050::Parameter> parameters,
                                   const Context& context) {
  const auto waiting = ParseWaitingOptions(options.waiting);
  if (!waiting) return Fail(waiting.error());
  if (options.if_any && !waiting->wait_for) {
    return Fail(ErrorKind::kUsage, "--if-any needs --wait");
  }
  auto target_request = ParseTargetOptions(options.targets);
  if (!target_request) return Fail(std::move(target_request.error()));
  auto targets = app::ResolveTargets(*std::move(target_request), context.config, context.output);
  if (!targets) return Fail(std::move(targets.error()));
  if (auto ok = CheckOneSpot(options, type, *targets); !ok) return Fail(std::move(ok.error()));
  auto resolver = app::DialectResolver::Make(options.instant.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  const auto action = BuildInstantAction(options.instant, type, std::move(parameters),
                                         targets->IsSet() ? 2 : targets->include.robots.size());
  if (!action) return Fail(action.error());
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  return SendToRobots(
      {.targets = *std::move(targets),
       .resolver = *std::move(resolver),
       .title = std::string(type),
       .needs_consent = app::DecideConsent(type),
       .header_id = options.instant.header_id,
       .make_message =
           [&] { return app::MakeInstantMessage(*action, options.instant.id.has_value()); },
       .waiting = *waiting},
      *settings, context, options.if_any);
}

}  // namespace fleetpub::cli
