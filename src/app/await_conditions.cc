#include "app/await_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "app/robot_discovery.h"
#include "app/targets.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/subscription.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::app {
namespace {

using std::chrono::steady_clock;
using vda5050::Condition;
using vda5050::RobotAddress;

// What to listen to.
struct Places {
  std::vector<vda5050::TopicScheme> schemes;
  std::vector<std::string> filters;
};

// Adds those of one robot.
Status AddPlaces(const AwaitRequest& request, const RobotAddress& robot,
                 const config::Config& config, Places& places) {
  // A version that the configuration names is none that the robot must keep to here.
  VdaOptions vda = WithConfig(request.vda, config, robot);
  vda.version = request.vda.version;
  const auto dialect = ParseDialect(vda);
  if (!dialect) return Fail(dialect.error());
  const vda5050::TopicScheme& scheme = dialect->topics;
  if (std::find(places.schemes.begin(), places.schemes.end(), scheme) == places.schemes.end()) {
    places.schemes.push_back(scheme);
  }
  if (request.vda.IsAutomatic()) {
    const std::string_view topic = request.topic;
    auto filters = vda5050::TopicsAnywhere(scheme, robot, {&topic, 1});
    if (!filters) return Fail(std::move(filters.error()));
    places.filters.insert(places.filters.end(), filters->begin(), filters->end());
    return {};
  }
  auto topic = vda5050::TopicFor(scheme, dialect->version, robot, request.topic);
  if (!topic) return Fail(std::move(topic.error()));
  places.filters.push_back(*std::move(topic));
  return {};
}

// What is misspelt would be waited for in vain. Errors: ErrorKind::kUsage.
Status CheckWords(const AwaitRequest& request, Log& log) {
  for (const Condition& condition : request.conditions) {
    const auto doubt = vda5050::CheckCondition(condition, request.topic);
    if (!doubt) return Fail(doubt.error());
    if (!doubt->empty()) log.Warn(*doubt);
  }
  const auto& topics = vda5050::kTopicNames;
  if (std::find(topics.begin(), topics.end(), request.topic) != topics.end()) return {};
  if (const auto nearest = base::Nearest(request.topic, topics)) {
    log.Warn(fmt::format("VDA 5050 has no topic {}: did you mean {}?",
                         base::Printable(request.topic), *nearest));
  }
  return {};
}

// Those of a pattern that the broker knows.
Result<std::vector<RobotAddress>> FindRobots(const AwaitRequest& request,
                                             const vda5050::RobotPattern& pattern,
                                             mqtt::Transport& transport,
                                             const Environment& environment, Log& log) {
  const auto dialect = ParseDialect(WithConfig(request.vda, environment.config));
  if (!dialect) return Fail(dialect.error());
  const auto is_other = [&](const RobotAddress& robot) { return !pattern.Matches(robot); };
  auto robots = ListRobots(transport, dialect->topics,
                           environment.recording ? PatientOptions() : delivery::RetainedOptions());
  std::erase_if(robots, is_other);
  if (robots.empty()) {
    const auto expected =
        FindExpectedRobots(environment, transport.server(),
                           [&](const RobotAddress& robot) -> std::optional<vda5050::TopicScheme> {
                             if (is_other(robot)) return std::nullopt;
                             return dialect->topics;
                           });
    robots = ListByName(transport, dialect->topics, expected, {});
  }
  WarnOfEscapedNames(robots, log);
  if (!robots.empty()) return robots;
  return Fail(ErrorKind::kPreflight,
              fmt::format("the broker knows no robot {}", base::Printable(request.target)));
}

class Awaiter {
 public:
  Awaiter(const AwaitRequest& request, const std::vector<RobotAddress>& robots,
          const SatisfiedHook& satisfied, const Environment& environment,
          steady_clock::time_point start)
      : request_(request),
        satisfied_(satisfied),
        recording_(environment.recording.get()),
        start_(start) {
    for (const RobotAddress& robot : robots) left_[robot];
  }

  Status Run(Link link, Places places, Log& log) {
    auto subscription = delivery::Subscription::Open(
        std::move(link.transport), std::move(places.filters),
        MakeReconnectHooks(link.connection, log), start_ + request_.timeout);
    if (!subscription) return Fail(std::move(subscription.error()));
    const auto end = start_ + request_.timeout;
    log.Wait(DescribeLeft(), end);
    auto read = subscription->Read([&](const mqtt::Message& message) {
      const auto robot = FindSender(places.schemes, message.topic);
      if (robot == left_.end() || !Satisfies(message.payload, robot->second)) return false;
      satisfied_(robot->first, vda5050::ToOneLine(message.payload), Elapsed());
      left_.erase(robot);
      log.Wait(DescribeLeft(), end);
      return left_.empty();
    });
    log.Wait("");
    if (!left_.empty()) {
      return Fail(ErrorKind::kUnconfirmed, InVain(subscription->transport() != nullptr));
    }
    subscription->Disconnect();
    return read;
  }

 private:
  [[nodiscard]] std::chrono::nanoseconds Elapsed() const {
    return recording_ != nullptr ? recording_->elapsed() : steady_clock::now() - start_;
  }

  [[nodiscard]] std::string DescribeLeft() const {
    if (left_.empty()) return "";
    return "waiting for " + (left_.size() == 1 ? base::Printable(left_.begin()->first.ToString())
                                               : fmt::format("{} robots", left_.size()));
  }

  // What one robot has said so far.
  struct Heard {
    bool came = false;
    int unreadable = 0;
    std::vector<std::string> unmet;  ///< of its last message
  };
  using Left = std::map<RobotAddress, Heard>;

  // Whose message it is, of those that are waited for.
  Left::iterator FindSender(const std::vector<vda5050::TopicScheme>& schemes,
                            const std::string& topic) {
    for (const vda5050::TopicScheme& scheme : schemes) {
      const auto levels = vda5050::ReadTopic(scheme, topic);
      if (!levels || levels->topic_name != request_.topic) continue;
      const auto found = left_.find(levels->robot);
      if (found != left_.end()) return found;
    }
    return left_.end();
  }

  bool Satisfies(const std::string& payload, Heard& heard) const {
    if (payload.empty()) return false;  // a retained message was deleted
    heard.came = true;
    heard.unmet.clear();
    const auto message = vda5050::ReadMessage(payload);
    if (!message) {
      ++heard.unreadable;
      heard.unmet.push_back(message.error().message);
      return false;
    }
    for (const Condition& condition : request_.conditions) {
      if (auto unmet = vda5050::Unmet(condition, *message)) {
        heard.unmet.push_back(*std::move(unmet));
      }
    }
    return heard.unmet.empty();
  }

  // Of one robot why, of several who.
  [[nodiscard]] std::string InVain(bool connected) const {
    const std::string topic = base::Printable(request_.topic);
    const std::string time =
        recording_ != nullptr ? "the recording" : base::FormatElapsed(request_.timeout);
    const std::string away = connected ? "" : "; the broker was out of reach at the end";
    const auto& [robot, heard] = *left_.begin();
    const std::string name = base::Printable(robot.ToString());
    const std::string others =
        left_.size() == 1 ? "" : fmt::format("; nor {} others", left_.size() - 1);
    if (!heard.came) {
      const bool too_soon = recording_ == nullptr && request_.topic == "state" &&
                            request_.timeout < std::chrono::seconds(30);
      return fmt::format("{}: no {} message came within {}{}{}{}", name, topic, time,
                         too_soon ? " (robots send one at least every 30 s)" : "", others, away);
    }
    const std::string unreadable =
        heard.unreadable == 0 ? "" : fmt::format("; {} could not be read", heard.unreadable);
    return fmt::format("{}: condition not met within {}: in its last {} message {}{}{}{}", name,
                       time, topic, base::Join(heard.unmet, ", "), unreadable, others, away);
  }

  const AwaitRequest& request_;
  const SatisfiedHook& satisfied_;
  const delivery::PlayedRecording* recording_;  // null: a broker
  steady_clock::time_point start_;
  Left left_;
};

}  // namespace

Status AwaitConditions(const AwaitRequest& request, const Environment& environment,
                       const SatisfiedHook& satisfied, Log& log) {
  const auto start = steady_clock::now();
  if (auto ok = CheckWords(request, log); !ok) return ok;
  auto spec = ParseTargetSpec({request.target}, environment.config, log);
  if (!spec) return Fail(std::move(spec.error()));
  Places places;
  const auto add = [&](const std::vector<RobotAddress>& robots) {
    Status ok;
    for (const RobotAddress& robot : robots) {
      if (ok) ok = AddPlaces(request, robot, environment.config, places);
    }
    return ok;
  };
  if (auto ok = add(spec->robots); !ok) return ok;
  auto link = Connect(environment, log);
  if (!link) return Fail(std::move(link.error()));
  if (!spec->patterns.empty()) {
    auto found = FindRobots(request, spec->patterns.front(), *link->transport, environment, log);
    if (!found) return Fail(std::move(found.error()));
    spec->robots = *std::move(found);
    if (auto ok = add(spec->robots); !ok) return ok;
  }
  return Awaiter(request, spec->robots, satisfied, environment, start)
      .Run(*std::move(link), std::move(places), log);
}

}  // namespace fleetpub::app
