#include "cli/instant_sending.h"

#include <memory>

#include "app/send_command.h"
#include "cli/environment.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "vda5050/rules/preflight.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::cli {
namespace {

using vda5050::Dialect;
using vda5050::InstantAction;
using vda5050::RobotAddress;

class InstantMessage final : public app::RobotMessage {
 public:
  InstantMessage(InstantAction action, bool has_given_id)
      : action_(std::move(action)), has_given_id_(has_given_id) {
    if (!has_given_id_) action_.id = vda5050::MakeActionId(nullptr);
  }

  [[nodiscard]] Result<message::Command> Build(
      const RobotAddress& robot, const Dialect& dialect,
      std::optional<std::uint32_t> header_id) const override {
    return vda5050::BuildInstantActions(robot, dialect, {&action_, 1}, header_id);
  }

  [[nodiscard]] vda5050::PreflightFindings Check(const RobotAddress& robot, const Dialect& dialect,
                                                 const vda5050::KnownRobot& known) const override {
    InstantAction named = action_;
    named.type = vda5050::NameIn(dialect.version, named.type);
    const auto command = vda5050::BuildInstantActions(robot, dialect, {&named, 1});
    const std::size_t bytes =
        command ? command->payload.Render(0, base::WallTime::clock::now()).size() : 0;
    return vda5050::CheckRobot(robot, dialect, {&named, 1}, known, bytes);
  }

  [[nodiscard]] Result<std::unique_ptr<message::ResponseTracker>> Track(
      const RobotAddress& robot, const Dialect& dialect, const message::Command& command,
      vda5050::WaitFor wait_for) const override {
    const message::ActionRef& action = command.actions.front();
    return vda5050::TrackInstantAction(robot, dialect, action.type, action.id, wait_for);
  }

  [[nodiscard]] bool IsOnlyStartPause() const override {
    return vda5050::IsOnlyStartPause({&action_, 1});
  }
  [[nodiscard]] bool NeedsFactsheet() const override {
    return vda5050::NeedsFactsheet({&action_, 1});
  }
  [[nodiscard]] bool IsAlikeForAll() const override { return true; }

  void ApplyLimits(const vda5050::Factsheet& factsheet) override {
    if (!has_given_id_) action_.id = vda5050::MakeActionId(&factsheet);
  }

 private:
  InstantAction action_;
  bool has_given_id_;
};

}  // namespace

void DeclareInstantSendingOptions(OptionSet& set, InstantSendingOptions& options) {
  DeclareTargetOptions(set, options.targets);
  DeclareInstantOptions(set, options.instant);
  DeclareSendingOptions(set, options.sending);
  DeclareManyOptions(set, options.sending);
  DeclareWaitingOptions(set, options.waiting);
  DeclareVdaOptions(set, options.instant.vda);
}

Result<ExitCode> SendToRobots(const app::CommandRequest& request, const app::SendSettings& settings,
                              const Context& context) {
  using Show = SendingObserver::Show;
  SendingObserver observer(context.output,
                           settings.dry_run          ? Show::kPayloads
                           : request.targets.IsSet() ? Show::kResultsAndProgress
                                                     : Show::kResults,
                           FormatSite(context));
  auto sent = app::SendCommand(request, settings, MakeEnvironment(context), observer);
  if (!sent) return Fail(std::move(sent.error()));
  return observer.Conclude();
}

Result<ExitCode> SendInstantAction(const InstantSendingOptions& options, std::string_view type,
                                   std::vector<vda5050::Parameter> parameters,
                                   const Context& context) {
  const auto waiting = ParseWaitingOptions(options.waiting);
  if (!waiting) return Fail(waiting.error());
  auto target_request = ParseTargetOptions(options.targets);
  if (!target_request) return Fail(std::move(target_request.error()));
  auto targets = app::ResolveTargets(*std::move(target_request), context.config, context.output);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::For(options.instant.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  const auto action = BuildInstantAction(options.instant, type, std::move(parameters),
                                         targets->IsSet() ? 2 : targets->include.robots.size());
  if (!action) return Fail(action.error());
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  return SendToRobots({.targets = *std::move(targets),
                       .resolver = *std::move(resolver),
                       .title = std::string(type),
                       .needs_consent = app::DecideConsent(type),
                       .header_id = options.instant.header_id,
                       .make_message =
                           [&] {
                             return std::make_unique<InstantMessage>(
                                 *action, options.instant.id.has_value());
                           },
                       .waiting = *waiting},
                      *settings, context);
}

}  // namespace fleetpub::cli
