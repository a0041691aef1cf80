#include "cli/commands/validate_live.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

#include "app/targets.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "delivery/subscription.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using vda5050::ValidationResult;

constexpr milliseconds kGlance{100};  // between two looks at whether to end

struct Tally {
  std::size_t messages = 0;
  std::size_t invalid = 0;
};

std::string TallyJson(const Tally& tally) {
  return fmt::format(R"("messages":{},"valid":{},"invalid":{})", tally.messages,
                     tally.messages - tally.invalid, tally.invalid);
}

std::string TallyText(const Tally& tally) {
  return fmt::format("{} message{}, {} valid, {} invalid", tally.messages,
                     tally.messages == 1 ? "" : "s", tally.messages - tally.invalid, tally.invalid);
}

// Judges and tells, message after message.
class Inspector {
 public:
  Inspector(vda5050::Conformance& conformance, Output& output)
      : conformance_(conformance), output_(output) {}

  void Take(const mqtt::Message& message) {
    if (message.retained && !IsNew(message)) return;
    const auto judgement = conformance_.Validate(message.topic, message.payload);
    if (!judgement) return;
    if (vda5050::IsWrittenOtherwise(judgement->robot) && escaped_.insert(judgement->robot).second) {
      app::WarnOfEscapedNames({&judgement->robot, 1}, output_);
    }
    for (Tally* tally : {&total_, &by_topic_[judgement->topic_name]}) {
      ++tally->messages;
      if (!judgement->findings.errors.empty()) ++tally->invalid;
    }
    for (const auto& violation : judgement->findings.errors) Tell(message, *judgement, violation);
    for (const auto& [path, words] : judgement->findings.warnings) {
      output_.Warn(fmt::format("{}: {}", PlaceOf(message, *judgement), words));
    }
  }

  void TellSummary() const {
    if (output_.json()) {
      std::string topics;
      for (const auto& [topic, tally] : by_topic_) {
        topics +=
            fmt::format(R"({}"{}":{{{}}})", topics.empty() ? "" : ",", topic, TallyJson(tally));
      }
      output_.Line(fmt::format(R"({{{},"topics":{{{}}}}})", TallyJson(total_), topics));
      return;
    }
    for (const auto& [topic, tally] : by_topic_) {
      output_.PeopleLine(fmt::format("{:<14}  {}", topic, TallyText(tally)));
    }
    output_.PeopleLine(fmt::format("{:<14}  {}", "all", TallyText(total_)));
  }

  [[nodiscard]] const Tally& total() const { return total_; }

 private:
  // Retained messages come again with each new connection.
  bool IsNew(const mqtt::Message& message) {
    const std::size_t hash = std::hash<std::string>()(message.payload);
    const auto [known, added] = retained_.try_emplace(message.topic, hash);
    return added || std::exchange(known->second, hash) != hash;
  }

  static std::string PlaceOf(const mqtt::Message& message, const ValidationResult& judgement) {
    return fmt::format("{} {}{}{}", base::Printable(judgement.robot.ToString()),
                       judgement.topic_name,
                       judgement.header_id ? fmt::format(" headerId {}", *judgement.header_id) : "",
                       message.retained ? " (retained)" : "");
  }

  void Tell(const mqtt::Message& message, const ValidationResult& judgement,
            const schema::Violation& violation) const {
    if (!output_.json()) {
      const std::string path = base::Printable(violation.path);
      return output_.Line(fmt::format("{}: {}{}{}", PlaceOf(message, judgement), path,
                                      path.empty() ? "" : ": ", violation.message));
    }
    output_.Line(fmt::format(
        R"({{"target":{},"topic":{},"version":"{}","headerId":{},"retained":{},"path":{},"message":{}}})",
        base::JsonString(judgement.robot.ToString()), base::JsonString(message.topic),
        judgement.version, judgement.header_id ? std::to_string(*judgement.header_id) : "null",
        message.retained, base::JsonString(violation.path), base::JsonString(violation.message)));
  }

  vda5050::Conformance& conformance_;
  Output& output_;
  Tally total_;
  std::map<std::string, Tally> by_topic_;
  std::set<vda5050::RobotAddress> escaped_;                // whose names were warned of
  std::unordered_map<std::string, std::size_t> retained_;  // by topic, the payload's hash
};

Result<vda5050::ConformanceOptions> ConformanceOptionsOf(const LiveOptions& options,
                                                         const LiveRequest& request) {
  vda5050::ConformanceOptions conformance;
  const auto dialect = app::ParseDialect(options.vda);
  if (!dialect) return Fail(dialect.error());
  conformance.scheme = dialect->topics;
  auto pattern = vda5050::ParseRobotPattern(request.pattern.empty() ? "*/*" : request.pattern);
  if (!pattern) return Fail(std::move(pattern.error()));
  conformance.pattern = std::move(*pattern);
  if (!request.version.empty()) {
    const auto version = vda5050::ParseVersion(request.version);
    if (!version) return Fail(version.error());
    conformance.version = *version;
  }
  conformance.topic = request.topic;
  conformance.strict = request.strict;
  return conformance;
}

}  // namespace

void DeclareLive(OptionSet& set, LiveOptions& options) {
  constexpr const char* kLive = "Live";
  set.AddFlag("--live", options.live,
              "Check what robots and fleet controls publish; FILE is a PATTERN of robots then")
      .Group(kLive);
  set.AddOption("--for", options.duration, "End after this time [on Ctrl-C]")
      .Type("TIME")
      .Group(kLive);
  set.AddOption("--count", options.count, "End after so many messages")
      .Type("N")
      .InRange(1, 1'000'000'000'000)
      .Group(kLive);
  DeclareTopicOptions(set, options.vda);
}

Result<ExitCode> ValidateLive(const LiveOptions& options, const LiveRequest& request,
                              const Context& context) {
  auto conformance_options = ConformanceOptionsOf(options, request);
  if (!conformance_options) return Fail(std::move(conformance_options.error()));
  schema::Registry registry(context.options.schema_directory);
  vda5050::Conformance conformance(std::move(*conformance_options), registry);
  auto filters = conformance.Filters();
  if (!filters) return Fail(std::move(filters.error()));
  const auto end = ParseEnd(options.duration);
  if (!end) return Fail(end.error());
  const auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(connect.error());

  const StopSignal stop;
  Output& output = context.output;
  auto listener = delivery::Subscription::Open(*std::move(filters), MakeConnectHook(*connect),
                                               MakeListenHooks(output), *end);
  if (!listener) return Fail(std::move(listener.error()));
  Inspector inspector(conformance, output);
  const auto enough = options.count == 0 ? SIZE_MAX : static_cast<std::size_t>(options.count);
  while (steady_clock::now() < *end && inspector.total().messages < enough &&
         !StopSignal::Noted()) {
    const auto message = (*listener)->Next(std::min(*end, steady_clock::now() + kGlance));
    if (message) inspector.Take(*message);
    if (auto flushed = output.Flush(); !flushed) return Fail(std::move(flushed.error()));
  }
  (*listener)->Disconnect();
  inspector.TellSummary();
  if (inspector.total().messages == 0) {
    return Fail(ErrorKind::kUnconfirmed, "no message came: nothing was checked");
  }
  return inspector.total().invalid > 0 ? ExitCode::kInvalid : ExitCode::kDone;
}

}  // namespace fleetpub::cli
