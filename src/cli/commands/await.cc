// `fleetpub await TARGET TOPIC CONDITION…`: waits until a message of each robot says so.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "app/robot_discovery.h"
#include "app/targets.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/output/interrupt.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "delivery/subscription.h"
#include "mqtt/paho/paho_transport.h"
#include "vda5050/reports/condition.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;
using vda5050::Condition;
using vda5050::RobotAddress;

struct Options {
  std::string target;
  std::string topic;
  std::vector<std::string> conditions;
  std::string timeout = "10m";
  app::VdaOptions vda;
};

struct Wish {
  std::vector<RobotAddress> robots;
  std::vector<vda5050::TopicScheme> schemes;  ///< of their topics
  std::string topic;                          ///< its name
  std::vector<std::string> filters;
  std::vector<Condition> conditions;
  std::chrono::milliseconds timeout{};
};

// Adds what to listen to for one robot.
Status Listen(const Options& o, const RobotAddress& robot, const config::Config& config,
              Wish& wish) {
  // A version that the configuration names is none that the robot must keep to here.
  app::VdaOptions vda = app::Configured(o.vda, config, robot);
  vda.version = o.vda.version;
  const auto dialect = app::ParseDialect(vda);
  if (!dialect) return Fail(dialect.error());
  const vda5050::TopicScheme& scheme = dialect->topics;
  if (std::find(wish.schemes.begin(), wish.schemes.end(), scheme) == wish.schemes.end()) {
    wish.schemes.push_back(scheme);
  }
  if (o.vda.IsAutomatic()) {
    const std::string_view topic = o.topic;
    auto filters = vda5050::TopicsAnywhere(scheme, robot, {&topic, 1});
    if (!filters) return Fail(std::move(filters.error()));
    wish.filters.insert(wish.filters.end(), filters->begin(), filters->end());
    return {};
  }
  auto topic = vda5050::TopicFor(scheme, dialect->version, robot, o.topic);
  if (!topic) return Fail(std::move(topic.error()));
  wish.filters.push_back(*std::move(topic));
  return {};
}

// A misspelt topic would be waited for in vain.
void WarnOfTopic(const std::string& topic, Output& output) {
  constexpr std::array<std::string_view, 8> kTopics = {
      "state",          "connection", "factsheet", "visualization",
      "instantActions", "order",      "responses", "zoneSet"};
  if (std::find(kTopics.begin(), kTopics.end(), topic) != kTopics.end()) return;
  if (const auto nearest = base::Nearest(topic, kTopics)) {
    output.Warn(fmt::format("VDA 5050 has no topic {}: did you mean {}?", base::Printable(topic),
                            *nearest));
  }
}

// Those that the word means; a pattern's are those that the broker knows now.
Result<std::vector<RobotAddress>> RobotsMeant(const Options& o, const Context& context) {
  auto words = app::ParseTargetSpec({o.target}, context.config, context.output);
  if (!words) return Fail(std::move(words.error()));
  if (words->patterns.empty()) return std::move(words->robots);
  const auto dialect = app::ParseDialect(app::Configured(o.vda, context.config));
  if (!dialect) return Fail(dialect.error());
  const auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(connect.error());
  const auto transport = mqtt::ConnectPaho(*connect);
  if (!transport) return Fail(transport.error());
  auto robots = app::ListRobots(**transport, dialect->topics, {});
  (*transport)->Disconnect();
  std::erase_if(robots,
                [&](const RobotAddress& robot) { return !words->patterns.front().Matches(robot); });
  app::WarnOfEscapedNames(robots, context.output);
  if (!robots.empty()) return robots;
  return Fail(ErrorKind::kPreflight,
              fmt::format("the broker knows no robot {}", base::Printable(o.target)));
}

Result<Wish> WishOf(const Options& o, const Context& context) {
  constexpr std::string_view kForm =
      "await TARGET TOPIC CONDITION..., such as "
      "await KIT/0001 state paused=true";
  if (o.target.empty() || o.topic.empty() || o.conditions.empty()) {
    return Fail(ErrorKind::kUsage, fmt::format("say whom, what and until when: {}", kForm));
  }
  Wish wish{.robots = {}, .schemes = {}, .topic = o.topic, .filters = {}, .conditions = {}};
  for (const std::string& text : o.conditions) {
    auto condition = vda5050::ParseCondition(text);
    if (!condition) return Fail(std::move(condition.error()));
    const auto doubt = vda5050::CheckCondition(*condition, o.topic);
    if (!doubt) return Fail(doubt.error());
    if (!doubt->empty()) context.output.Warn(*doubt);
    wish.conditions.push_back(*std::move(condition));
  }
  const auto timeout = base::ParseDuration(o.timeout);
  if (!timeout) return Fail(timeout.error());
  wish.timeout = *timeout;
  auto robots = RobotsMeant(o, context);
  if (!robots) return Fail(std::move(robots.error()));
  wish.robots = *std::move(robots);
  for (const RobotAddress& robot : wish.robots) {
    if (auto ok = Listen(o, robot, context.config, wish); !ok) return Fail(std::move(ok.error()));
  }
  return wish;
}

class Awaiter {
 public:
  Awaiter(const Wish& wish, const Context& context)
      : wish_(wish), context_(context), start_(steady_clock::now()) {}

  Result<ExitCode> Run() {
    auto connect = MakeConnectOptions(context_);
    if (!connect) return Fail(std::move(connect.error()));
    const InterruptGuard interrupt;
    start_ = steady_clock::now();
    const auto end = start_ + wish_.timeout;
    // To connect may take its own time, however short the wait.
    auto listener = delivery::Subscription::Open(wish_.filters, MakeConnectHook(*connect),
                                                 MakeListenHooks(context_.output),
                                                 std::max(end, start_ + connect->connect_timeout));
    if (!listener) return Fail(std::move(listener.error()));
    for (const RobotAddress& robot : wish_.robots) left_[robot];
    do {
      const auto message = (*listener)->Next(end);
      if (!message) continue;
      const auto robot = SenderOf(message->topic);
      if (robot == left_.end() || !Satisfies(message->payload, robot->second)) continue;
      Show(robot->first, message->payload);
      left_.erase(robot);
    } while (!left_.empty() && steady_clock::now() < end);
    const bool connected = (*listener)->connected();
    if (!left_.empty()) return Fail(ErrorKind::kUnconfirmed, InVain(connected));
    (*listener)->Disconnect();
    return ExitCode::kDone;
  }

 private:
  // What one robot has said so far.
  struct Heard {
    bool came = false;
    int unreadable = 0;
    std::vector<std::string> unmet;  ///< of its last message
  };
  using Left = std::map<RobotAddress, Heard>;

  // Whose message it is, of those that are waited for.
  Left::iterator SenderOf(const std::string& topic) {
    for (const vda5050::TopicScheme& scheme : wish_.schemes) {
      const auto levels = vda5050::ReadTopic(scheme, topic);
      const auto found = levels ? left_.find(levels->robot) : left_.end();
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
    for (const Condition& condition : wish_.conditions) {
      if (auto unmet = vda5050::Unmet(condition, *message)) {
        heard.unmet.push_back(*std::move(unmet));
      }
    }
    return heard.unmet.empty();
  }

  void Show(const RobotAddress& robot, const std::string& payload) const {
    // One line: as the robot wrote it, if it wrote one of valid JSON.
    const bool is_line = payload.find_first_of("\r\n\xEF") == std::string::npos;
    const std::string line = is_line && base::ParseJson(payload)
                                 ? payload
                                 : base::ToJson(*vda5050::ReadMessage(payload));
    if (context_.output.json()) {
      context_.output.Line(line);
    } else {
      context_.output.PeopleLine(fmt::format(
          "{}  {}  {}  {}", base::Printable(robot.ToString()), base::Printable(wish_.topic),
          base::FormatElapsed(steady_clock::now() - start_), base::Printable(line)));
    }
    Output::FlushNow();
  }

  // Of one robot why, of several who.
  [[nodiscard]] std::string InVain(bool connected) const {
    const std::string topic = base::Printable(wish_.topic);
    const std::string time = base::FormatElapsed(wish_.timeout);
    const std::string away = connected ? "" : "; the broker was out of reach at the end";
    const auto& [robot, heard] = *left_.begin();
    const std::string name = base::Printable(robot.ToString());
    const std::string others =
        left_.size() == 1 ? "" : fmt::format("; nor {} others", left_.size() - 1);
    if (!heard.came) {
      const bool too_soon = wish_.topic == "state" && wish_.timeout < std::chrono::seconds(30);
      return fmt::format("{}: no {} message came within {}{}{}{}", name, topic, time,
                         too_soon ? " (robots send one at least every 30 s)" : "", others, away);
    }
    const std::string unreadable =
        heard.unreadable == 0 ? "" : fmt::format("; {} could not be read", heard.unreadable);
    return fmt::format("{}: not so within {}: in its last {} message {}{}{}{}", name, time, topic,
                       base::Join(heard.unmet, ", "), unreadable, others, away);
  }

  const Wish& wish_;
  const Context& context_;
  steady_clock::time_point start_;
  Left left_;
};

Result<ExitCode> RunAwait(const Options& o, const Context& context) {
  const auto wish = WishOf(o, context);
  if (!wish) return Fail(wish.error());
  WarnOfTopic(wish->topic, context.output);
  return Awaiter(*wish, context).Run();
}

}  // namespace

Run DeclareAwait(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  set.AddOption("target", options->target,
                "A robot: manufacturer/serialNumber, or its alias; all of @group, of 'KIT/*'")
      .Type("TARGET");
  set.AddOption("topic", options->topic, "state, connection, factsheet ...").Type("TOPIC");
  set.AddOption("conditions", options->conditions, "What one message must say").Type("CONDITION");
  set.AddOption("-W,--timeout", options->timeout, "How long to wait [10m]")
      .Type("TIME")
      .Group("Waiting");
  set.AddOption("--vda", options->vda.version,
                "Listen to this version's topic only [auto: whichever the robot uses]")
      .Type("V")
      .Variable("FLEETPUB_VDA")
      .Group("VDA 5050");
  DeclareTopicOptions(set, options->vda);
  return [options](const Context& context) { return RunAwait(*options, context); };
}

}  // namespace fleetpub::cli
