#include "cli/robot_sending.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "base/text.h"
#include "dispatch/collect.h"
#include "dispatch/send.h"
#include "mqtt/paho_transport.h"
#include "vda5050/discovery.h"

namespace fleetpub::cli {
namespace {

using dispatch::Command;
using vda5050::Dialect;
using vda5050::KnownRobot;
using vda5050::RobotAddress;

// In the order in which a broker hands them out: when the connection message is there, so is the
// factsheet.
constexpr std::array<std::string_view, 2> kRetainedTopics = {"factsheet", "connection"};

// One robot on the way to its command.
struct Addressee {
  RobotAddress robot;
  Dialect dialect;
  bool automatic;  ///< its own dialect is to be learnt
  std::unique_ptr<RobotMessage> message;
  KnownRobot known = {};
  bool unspeakable = false;  ///< it speaks a version that we do not
};

bool SaysOnline(const mqtt::Message& message) {
  if (!message.topic.ends_with("/connection")) return false;
  const auto connection = vda5050::ReadConnection(message.payload);
  return connection && connection->connection_state == "ONLINE";
}

// The robot's topics in whichever interface and version.
Result<std::vector<std::string>> AnyTopics(const vda5050::TopicScheme& scheme,
                                           const RobotAddress& robot,
                                           std::span<const std::string_view> names) {
  return vda5050::DiscoveryFilters(scheme, {robot.manufacturer, robot.serial_number}, names);
}

bool IsSame(const vda5050::TopicScheme& a, const vda5050::TopicScheme& b) {
  return a.interface_name == b.interface_name && a.topic_template == b.topic_template;
}

class RobotSender {
 public:
  RobotSender(RobotSending sending, const Context& context)
      : sending_(std::move(sending)), waiting_(sending_.waiting), context_(context) {
    addressees_.reserve(sending_.robots.size());
    for (auto& [robot, dialect, is_automatic] : sending_.robots) {
      automatic_ = automatic_ || is_automatic;
      addressees_.push_back(
          {std::move(robot), std::move(dialect), is_automatic, sending_.make_message()});
    }
  }

  Result<ExitCode> Run() {
    if (!automatic_) {  // what is invalid anyway costs no connection
      if (auto ok = Build(); !ok) return Fail(ok.error());
    }
    const bool look = automatic_ || (waiting_.check && !sending_.options.dry_run);
    if (look) {
      if (auto ok = LookAround(); !ok) {
        return Fail(
            NothingSent(outgoing_.commands, dispatch::Verdict::kError, ok.error(), context_));
      }
      outgoing_.commands.clear();
      outgoing_.validated = false;
      Check();
      if (auto ok = Build(); !ok) return Fail(ok.error());
    }
    if (waiting_.wait_for) {
      if (auto ok = AddConfirmations(); !ok) return Fail(ok.error());
      outgoing_.wait = waiting_.wait;
    }
    for (const std::string& warning : warnings_) context_.output.Warn(warning);
    addressees_ = std::vector<Addressee>();  // of ten thousand robots it is felt
    return SendCommands(std::move(outgoing_), sending_.options, context_);
  }

 private:
  Status Build() {
    outgoing_.commands.reserve(addressees_.size());
    for (const Addressee& addressee : addressees_) {
      auto command =
          addressee.message->Build(addressee.robot, addressee.dialect, sending_.header_id);
      if (!command) return Fail(std::move(command.error()));
      outgoing_.commands.push_back(std::move(*command));
    }
    auto warnings = ValidateAll(outgoing_.commands, context_);
    if (!warnings) {
      return Fail(
          NothingSent(outgoing_.commands, dispatch::Verdict::kInvalid, warnings.error(), context_));
    }
    warnings_ = std::move(*warnings);
    outgoing_.validated = true;
    return {};
  }

  // What one robot has left at the broker.
  struct Traces {
    const Dialect* dialect = nullptr;       ///< that it is spoken to in at first
    std::vector<vda5050::Discovered> best;  ///< one, once there is any
    std::shared_ptr<const vda5050::Factsheet> factsheet;
  };

  using Heard = std::map<RobotAddress, Traces>;

  // Collects what the robots have said of themselves.
  Status LookAround() {
    const auto connect = ConnectOptionsOf(context_);
    if (!connect) return Fail(connect.error());
    auto transport = mqtt::ConnectPaho(*connect);
    if (!transport) return Fail(transport.error());
    outgoing_.transport = std::move(*transport);
    auto heard = Ears();
    dispatch::CollectOptions discover = waiting_.discover;
    discover.subscribe = connect->connect_timeout;
    if (auto ok = Ask(AnyTopics, discover, heard); !ok) return ok;
    // RabbitMQ has nothing retained for a filter with wildcards.
    if (auto ok = Ask(vda5050::SpecifiedTopics, discover, heard); !ok) return ok;
    for (Addressee& addressee : addressees_) {
      const auto traces = heard.find(addressee.robot);
      if (traces == heard.end() || traces->second.best.empty()) continue;
      Apply(std::move(traces->second), addressee);
    }
    return {};
  }

  // Collects what the robots that were not heard yet have left on the topics that `topics_of`
  // names.
  Status Ask(const auto& topics_of, const dispatch::CollectOptions& discover, Heard& heard) {
    std::vector<std::string> filters;
    std::size_t wanted = 0;
    for (const Addressee& addressee : addressees_) {
      const auto traces = heard.find(addressee.robot);
      if (traces == heard.end() || !traces->second.best.empty()) continue;
      ++wanted;
      const auto own = topics_of(addressee.dialect.topics, addressee.robot, kRetainedTopics);
      if (!own) return Fail(own.error());
      filters.insert(filters.end(), own->begin(), own->end());
    }
    if (wanted == 0) return {};
    // A robot may have left messages under another version long ago: only ONLINE ends the search at
    // once.
    const auto schemes = Schemes();
    std::size_t online = 0;
    return dispatch::Collect(*outgoing_.transport, filters, discover,
                             [&](const mqtt::Message& message) {
                               Hear(message, schemes, heard);
                               if (SaysOnline(message)) ++online;
                               return online >= wanted;
                             });
  }

  [[nodiscard]] Heard Ears() const {
    Heard heard;
    for (const Addressee& addressee : addressees_) {
      if (IsLookedFor(addressee)) heard[addressee.robot].dialect = &addressee.dialect;
    }
    return heard;
  }

  // The topics' shapes among the robots: few, however many robots there are.
  [[nodiscard]] std::vector<vda5050::TopicScheme> Schemes() const {
    std::vector<vda5050::TopicScheme> schemes;
    for (const Addressee& addressee : addressees_) {
      const auto same = [&](const auto& scheme) {
        return IsSame(scheme, addressee.dialect.topics);
      };
      if (std::none_of(schemes.begin(), schemes.end(), same)) {
        schemes.push_back(addressee.dialect.topics);
      }
    }
    return schemes;
  }

  // Finds out whose message this is, by the shape of each robot's own topics.
  void Hear(const mqtt::Message& message, const std::vector<vda5050::TopicScheme>& schemes,
            Heard& heard) {
    for (const vda5050::TopicScheme& scheme : schemes) {
      const auto levels = vda5050::ReadTopic(scheme, message.topic);
      if (!levels) continue;
      const auto traces = heard.find(levels->robot);
      if (traces == heard.end() || !IsSame(traces->second.dialect->topics, scheme)) continue;
      Note(message, traces->second);
      return;
    }
  }

  // What a message tells; with `--vda auto` a robot is from now on spoken to as they say.
  void Note(const mqtt::Message& message, Traces& traces) {
    auto discovered = vda5050::DialectFrom(*traces.dialect, message.topic, message.payload);
    if (!discovered) return;
    if (discovered->topic_name == "factsheet") {
      traces.factsheet = Share(vda5050::ReadFactsheet(message.payload));
    }
    traces.best.push_back(std::move(*discovered));
    traces.best = vda5050::OnePerRobot(std::move(traces.best));
  }

  // Thousands of robots of one make have said the same.
  std::shared_ptr<const vda5050::Factsheet> Share(std::optional<vda5050::Factsheet> factsheet) {
    if (!factsheet) return nullptr;
    for (const auto& known : factsheets_) {
      if (known->actions == factsheet->actions && known->limits == factsheet->limits) return known;
    }
    constexpr std::size_t kMakes = 16;
    auto shared = std::make_shared<const vda5050::Factsheet>(std::move(*factsheet));
    if (factsheets_.size() < kMakes) factsheets_.push_back(shared);
    return shared;
  }

  void Apply(Traces traces, Addressee& addressee) const {
    addressee.known.factsheet = std::move(traces.factsheet);
    const vda5050::Discovered best = std::move(traces.best.front());
    if (best.topic_name == "connection") {
      addressee.known.connection = best.message;
      addressee.known.connection_topic = best.topic;
    }
    addressee.unspeakable = !best.dialect;
    if (addressee.automatic && best.dialect) addressee.dialect = *best.dialect;
    if (addressee.known.factsheet) addressee.message->Suit(*addressee.known.factsheet);
  }

  // Sorts out the robots that cannot be expected to obey.
  void Check() {
    std::vector<Addressee> left;
    for (Addressee& addressee : addressees_) {
      if (!IsLookedFor(addressee)) {
        left.push_back(std::move(addressee));
        continue;
      }
      const vda5050::PreflightFindings findings = FindingsOn(addressee);
      for (const std::string& warning : findings.warnings) context_.output.Warn(warning);
      if (findings.refusals.empty()) {
        addressee.dialect.assumed = false;
        addressee.known = {};
        left.push_back(std::move(addressee));
      } else {
        Refuse(addressee, findings.refusals.front());
      }
    }
    addressees_ = std::move(left);
  }

  [[nodiscard]] vda5050::PreflightFindings FindingsOn(const Addressee& addressee) const {
    if (addressee.automatic && addressee.unspeakable) {
      return {{"it speaks a version of VDA 5050 that fleetpub does not: try one with --vda"}, {}};
    }
    if (!waiting_.check) {  // `--vda auto` alone: only the version must be known
      if (addressee.known.connection || addressee.known.factsheet) return {};
      return {{"no message of this robot is known to the broker, so its version cannot be told: "
               "name it with --vda"},
              {}};
    }
    return addressee.message->Check(addressee.robot, addressee.dialect, addressee.known);
  }

  void Refuse(const Addressee& addressee, const std::string& reason) {
    const auto command =
        addressee.message->Build(addressee.robot, addressee.dialect, sending_.header_id);
    dispatch::Report report = command ? dispatch::ReportOn(*command) : dispatch::Report();
    report.target = addressee.robot.ToString();
    report.verdict = dispatch::Verdict::kRefused;
    report.error = ErrorKind::kPreflight;
    report.message = "not sent: " + reason;
    outgoing_.refused.push_back(std::move(report));
  }

  Status AddConfirmations() {
    for (std::size_t i = 0; i < outgoing_.commands.size(); ++i) {
      Command& command = outgoing_.commands[i];
      auto confirmation = addressees_[i].message->Confirm(
          addressees_[i].robot, addressees_[i].dialect, command, *waiting_.wait_for);
      if (!confirmation) return Fail(std::move(confirmation.error()));
      command.confirmation = std::move(*confirmation);
    }
    return {};
  }

  [[nodiscard]] bool IsLookedFor(const Addressee& addressee) const {
    return waiting_.check || addressee.automatic;
  }

  RobotSending sending_;
  const Waiting& waiting_;
  const Context& context_;
  std::vector<Addressee> addressees_;
  bool automatic_ = false;  ///< of at least one
  std::vector<std::shared_ptr<const vda5050::Factsheet>> factsheets_;
  std::vector<std::string> warnings_;
  Outgoing outgoing_;
};

}  // namespace

Result<ExitCode> SendToRobots(RobotSending sending, const Context& context) {
  return RobotSender(std::move(sending), context).Run();
}

}  // namespace fleetpub::cli
