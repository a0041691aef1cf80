// `fleetpub publish TOPIC TARGET… -f FILE` sends a prepared message; `fleetpub respond` makes the
// one that answers a robot's request.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/file.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/instant_sending.h"
#include "cli/options/target_options.h"
#include "cli/options/vda_options.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/messages/user_message.h"

namespace fleetpub::cli {
namespace {

using vda5050::Dialect;
using vda5050::RobotAddress;

// What both commands take.
struct UserMessageOptions {
  std::optional<std::uint32_t> header_id;
  app::VdaOptions vda;
  SendingOptions sending;
  WaitingOptions waiting;
};

struct PublishOptions : UserMessageOptions {
  std::string topic;
  TargetOptions targets;
  std::string file;
  bool restamp = false;
};

constexpr auto kGrants =
    std::to_array<std::string_view>({"GRANTED", "QUEUED", "REVOKED", "REJECTED"});

struct RespondOptions : UserMessageOptions {
  std::string target;
  std::string request;
  std::string grant;
  std::optional<base::WallTime> lease_expiry;
};

void DeclareUserMessage(OptionSet& set, UserMessageOptions& options) {
  set.AddOption("--header-id", WholeNumber(options.header_id),
                "The headerId, above the topic's last [the next]")
      .Group("Message");
  DeclareSendingOptions(set, options.sending);
  DeclareManyOptions(set, options.sending);
  DeclareWaitingOptions(set, options.waiting);
  DeclareVdaOptions(set, options.vda);
}

Result<ExitCode> Send(std::string_view topic, const TargetOptions& target_options,
                      base::JsonDocument message, vda5050::HeaderMismatch on_mismatch,
                      const UserMessageOptions& options, const Context& context) {
  WaitingOptions waiting_options = options.waiting;
  // An order may take hours: that the robot has it is what one usually waits for.
  if (topic == "order" && waiting_options.wait && !waiting_options.wait_for) {
    waiting_options.wait_for = vda5050::WaitFor::kAccepted;
  }
  auto waiting = ParseWaitingOptions(waiting_options);
  if (!waiting) return Fail(std::move(waiting.error()));
  auto request = ParseTargetOptions(target_options);
  if (!request) return Fail(std::move(request.error()));
  auto targets = app::ResolveTargets(*std::move(request), context.config, context.output);
  if (!targets) return Fail(std::move(targets.error()));
  auto resolver = app::DialectResolver::Make(options.vda, context.config);
  if (!resolver) return Fail(std::move(resolver.error()));
  if (const auto said = vda5050::VersionSaidBy(message)) resolver->Assume(said->version);
  const auto settings = ParseSendingOptions(options.sending);
  if (!settings) return Fail(settings.error());

  if (waiting->wait_for) {  // what cannot be waited for costs no connection
    const RobotAddress anybody{"KIT", "0001"};
    const RobotAddress& first =
        targets->include.robots.empty() ? anybody : targets->include.robots.front();
    const auto possible =
        vda5050::TrackUserMessage(first, resolver->common(), topic, message, *waiting->wait_for);
    if (!possible) return Fail(possible.error());
  }
  const auto shared = std::make_shared<const base::JsonDocument>(std::move(message));
  return SendToRobots(
      {.targets = *std::move(targets),
       .resolver = *std::move(resolver),
       .title = std::string(topic),
       .needs_consent = app::NeedsConsent::kYes,
       .header_id = options.header_id,
       .make_message = [=] { return app::MakeUserMessage(topic, shared, on_mismatch); },
       .waiting = *waiting},
      *settings, context);
}

Result<base::JsonDocument> ReadMessage(const std::string& file) {
  const auto text = base::ReadFile(file);
  if (!text) return Fail(text.error());
  auto message = base::ParseJson(*text, {.exact = true});
  if (!message) {
    message.error().message =
        fmt::format("{}: {}", file == "-" ? "standard input" : file, message.error().message);
  }
  return message;
}

Result<ExitCode> RunPublish(const PublishOptions& options, const Context& context) {
  if (options.topic.empty()) {
    return Fail(
        ErrorKind::kUsage,
        "name the topic and the robots. try: fleetpub publish order KIT/0001 -f order.json");
  }
  if (options.file.empty()) {
    return Fail(ErrorKind::kUsage,
                "name the file with the message: --file FILE, or - for standard "
                "input");
  }
  const auto& words = options.targets.words;
  if (options.file == "-" && std::find(words.begin(), words.end(), "-") != words.end()) {
    return Fail(ErrorKind::kUsage,
                "standard input is the message or the targets, not both: put one into a file");
  }
  context.output.Reads(options.file);
  auto message = ReadMessage(options.file);
  if (!message) return Fail(std::move(message.error()));
  const auto on_mismatch =
      options.restamp ? vda5050::HeaderMismatch::kReplace : vda5050::HeaderMismatch::kRefuse;
  return Send(options.topic, options.targets, std::move(*message), on_mismatch, options, context);
}

Result<ExitCode> RunRespond(const RespondOptions& options, const Context& context) {
  if (options.grant.empty()) {
    return Fail(ErrorKind::kUsage,
                "name the robot, its request (fleetpub requests lists them) and the answer. try: "
                "fleetpub respond KIT/0001 request-1 GRANTED");
  }
  if (!base::IsUtf8(options.request)) {
    return Fail(ErrorKind::kUsage, "the requestId is not valid UTF-8");
  }
  const vda5050::RequestResponse response{.request_id = options.request,
                                          .grant_type = options.grant,
                                          .lease_expiry = options.lease_expiry};
  const auto robot = app::ResolveRobot(options.target, context.config);  // request ids are its own
  if (!robot) return Fail(robot.error());
  TargetOptions target;
  target.words = {robot->ToString()};
  return Send("responses", target, vda5050::ResponsesMessage(response),
              vda5050::HeaderMismatch::kRefuse, options, context);
}

}  // namespace

Run DeclarePublish(OptionSet& set) {
  const auto options = std::make_shared<PublishOptions>();
  set.AddOption("topic", OneOf(options->topic, vda5050::kCommandTopics), "{}").Type("TOPIC");
  DeclareTargetOptions(set, options->targets);
  set.AddOption("-f,--file", options->file, "The message as JSON; - reads standard input")
      .Type("FILE")
      .Group("Message");
  set.AddFlag("--restamp", options->restamp,
              "Replace a version, manufacturer or serialNumber of another robot in the message")
      .Group("Message");
  DeclareUserMessage(set, *options);
  return [options](const Context& context) { return RunPublish(*options, context); };
}

Run DeclareRespond(OptionSet& set) {
  const auto options = std::make_shared<RespondOptions>();
  set.AddOption("target", options->target, "The robot: manufacturer/serialNumber, or its alias")
      .Type("TARGET");
  set.AddOption("request", options->request, "Its requestId, as fleetpub requests lists it")
      .Type("REQUEST");
  set.AddOption("grant", OneOf(options->grant, kGrants), "{}").Type("ANSWER");
  set.AddOption("--lease-expiry", PointInTime(options->lease_expiry, base::Direction::kAhead),
                "Until when it is granted: 30s from now, or a time")
      .Group("Message");
  DeclareUserMessage(set, *options);
  return [options](const Context& context) { return RunRespond(*options, context); };
}

}  // namespace fleetpub::cli
