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
    if (!has_given_id_) action_.id = vda5050::SuitableActionId(nullptr);
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
      const RobotAddress& robot, const Dialect& dialect, vda5050::WaitFor wait_for) const override {
    return vda5050::TrackInstantAction(robot, dialect, action_, wait_for);
  }

  [[nodiscard]] bool IsAlikeForAll() const override { return true; }

  void ApplyLimits(const vda5050::Factsheet& factsheet) override {
    if (!has_given_id_) action_.id = vda5050::SuitableActionId(&factsheet);
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
                              const Context& context, bool no_order_is_fine) {
  using Show = SendingObserver::Show;
  SendingObserver observer(context.output,
                           request.targets.IsSet() ? Show::kResultsAndProgress : Show::kResults,
                           no_order_is_fine);
  auto sent = app::SendCommand(request, settings, MakeEnvironment(context), observer);
  if (!sent) return Fail(std::move(sent.error()));
  return observer.Conclude();
}

Result<ExitCode> SendInstantAction(const InstantSendingOptions& options, std::string_view type,
                                   std::vector<vda5050::Parameter> parameters,
                                   const Context& context) {
  const auto waiting = ParseWaitingOptions(options.waiting);
  if (!waiting) return Fail(waiting.error());
  if (options.if_any && !waiting->wait_for) {
    return Fail(ErrorKind::kUsage, "--if-any belongs to waiting: add --wait");
  }
  auto target_request = ParseTargetOptions(options.targets);
  if (!target_request) return Fail(std::move(target_request.error()));
  auto targets = app::ResolveTargets(*std::move(target_request), context.config, context.output);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::For(options.instant.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  const auto action = ActionOf(options.instant, type, std::move(parameters),
                               targets->IsSet() ? 2 : targets->include.robots.size());
  if (!action) return Fail(action.error());
  const auto header_id = HeaderIdOf(options.instant.header_id);
  if (!header_id) return Fail(header_id.error());
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  return SendToRobots({.targets = *std::move(targets),
                       .resolver = *std::move(resolver),
                       .needs_consent = app::DecideConsent(type),
                       .header_id = *header_id,
                       .make_message =
                           [&] {
                             return std::make_unique<InstantMessage>(
                                 *action, options.instant.id.has_value());
                           },
                       .waiting = *waiting},
                      *settings, context, options.if_any);
}

}  // namespace fleetpub::cli
