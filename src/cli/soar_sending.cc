#include "cli/soar_sending.h"

#include "cli/environment.h"
#include "cli/output/sending_observer.h"
#include "cli/parser/option_set.h"
#include "soar/acknowledgement_tracker.h"

namespace fleetpub::cli {

void DeclareSoarSendingOnly(OptionSet& set, SoarSendingOptions& options) {
  DeclareSendingOptions(set, options.sending);
  DeclareSoarOptions(set, options.soar);
}

void DeclareSoarSending(OptionSet& set, SoarSendingOptions& options) {
  DeclareSendingOptions(set, options.sending);
  DeclareSoarWaiting(set, options.waiting);
  DeclareSoarOptions(set, options.soar);
}

Result<ExitCode> SendSoarMessage(const SoarSendingOptions& options, soar::MessageType type,
                                 std::string_view payload, const Context& context) {
  const auto sender = ParseSender(options.soar);
  if (!sender) return Fail(sender.error());
  const auto destination = ParseDestination(options.soar, *sender, type);
  if (!destination) return Fail(destination.error());
  const auto waiting = ParseSoarWaiting(options.waiting, *destination);
  if (!waiting) return Fail(waiting.error());

  message::Command command = soar::BuildMessage(type, *destination, *sender, payload);
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());
  std::optional<delivery::WaitOptions> wait;
  if (waiting->wait_for) {
    wait = waiting->wait;
    command.tracker = soar::TrackAcknowledgements(
        {.message_id = command.actions.front().id,
         .topics = waiting->topics.empty()
                       ? soar::AcknowledgementTopics(*destination, sender->prefix, sender->source)
                       : waiting->topics,
         .prefix = sender->prefix,
         .wait_for = *waiting->wait_for,
         .count = waiting->count,
         .target = destination->name});
  }
  SendingObserver observer(
      context.output,
      settings->dry_run ? SendingObserver::Show::kPayloads : SendingObserver::Show::kResults,
      FormatSite(context));
  auto sent =
      app::SendMessages({std::move(command)}, *settings, wait, MakeEnvironment(context), observer);
  if (!sent) return Fail(std::move(sent.error()));
  return observer.Conclude();
}

}  // namespace fleetpub::cli
