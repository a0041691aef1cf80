// `fleetpub await TARGET TOPIC CONDITION…`: waits until a robot's message says so.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/interrupt.h"
#include "cli/listening.h"
#include "cli/option_set.h"
#include "cli/subcommand.h"
#include "cli/targets.h"
#include "dispatch/listen.h"
#include "vda5050/condition.h"

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
  VdaOptions vda;
};

struct Wish {
  RobotAddress robot;
  std::string topic;  ///< its name
  std::vector<std::string> filters;
  std::vector<Condition> conditions;
  std::chrono::milliseconds timeout{};
};

Result<std::vector<std::string>> FiltersOf(const Options& o, const RobotAddress& robot,
                                           const Config& config) {
  // A version that the configuration names is none that the robot must keep to here.
  VdaOptions vda = Configured(o.vda, config, robot);
  vda.version = o.vda.version;
  const auto dialect = DialectOf(vda);
  if (!dialect) return Fail(dialect.error());
  if (o.vda.version.empty() || o.vda.IsAutomatic()) {
    const std::string_view topic = o.topic;
    auto filters = vda5050::DiscoveryFilters(
        dialect->topics, {robot.manufacturer, robot.serial_number}, {&topic, 1});
    // RabbitMQ has nothing retained for a filter with wildcards.
    auto exact = vda5050::SpecifiedTopics(dialect->topics, robot, {&topic, 1});
    if (!filters || !exact) return Fail(std::move(filters ? exact.error() : filters.error()));
    filters->insert(filters->end(), exact->begin(), exact->end());
    return filters;
  }
  auto topic = vda5050::TopicFor(dialect->topics, dialect->version, robot, o.topic);
  if (!topic) return Fail(std::move(topic.error()));
  return std::vector{*std::move(topic)};
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

Result<Wish> WishOf(const Options& o, const Config& config) {
  constexpr std::string_view kForm =
      "await TARGET TOPIC CONDITION..., such as "
      "await KIT/0001 state paused=true";
  if (o.target.empty() || o.topic.empty() || o.conditions.empty()) {
    return Fail(ErrorKind::kUsage, fmt::format("say whom, what and until when: {}", kForm));
  }
  auto robot = RobotOf(o.target, config);
  if (!robot) return Fail(std::move(robot.error()));
  Wish wish{.robot = *std::move(robot), .topic = o.topic, .filters = {}, .conditions = {}};
  for (const std::string& text : o.conditions) {
    auto condition = vda5050::ParseCondition(text);
    if (!condition) return Fail(std::move(condition.error()));
    wish.conditions.push_back(*std::move(condition));
  }
  auto filters = FiltersOf(o, wish.robot, config);
  if (!filters) return Fail(std::move(filters.error()));
  wish.filters = *std::move(filters);
  const auto timeout = base::ParseDuration(o.timeout);
  if (!timeout) return Fail(timeout.error());
  wish.timeout = *timeout;
  return wish;
}

class Awaiter {
 public:
  Awaiter(const Wish& wish, const Context& context)
      : wish_(wish), context_(context), start_(steady_clock::now()) {}

  Result<ExitCode> Run() {
    auto connect = ConnectOptionsOf(context_);
    if (!connect) return Fail(std::move(connect.error()));
    const InterruptGuard interrupt(0);
    start_ = steady_clock::now();
    const auto end = start_ + wish_.timeout;
    Output& output = context_.output;
    const dispatch::ListenHooks hooks{
        [&](const Error& error) { output.Warn(error.message + ": connecting again"); },
        [&] { output.Warn("connected again"); }};
    // To connect may take its own time, however short the wait.
    auto listener = dispatch::Listener::Open(wish_.filters, ConnectHookOf(*connect), hooks,
                                             std::max(end, start_ + connect->connect_timeout));
    if (!listener) return Fail(std::move(listener.error()));
    do {
      const auto message = (*listener)->Next(end);
      if (message && Satisfies(message->payload)) {
        Show(message->payload);
        (*listener)->Disconnect();
        return ExitCode::kDone;
      }
    } while (steady_clock::now() < end);
    return Fail(ErrorKind::kUnconfirmed, InVain((*listener)->connected()));
  }

 private:
  bool Satisfies(const std::string& payload) {
    if (payload.empty()) return false;  // a retained message was deleted
    came_ = true;
    unmet_.clear();
    const auto message = base::ParseJson(payload);
    if (!message || !message->IsObject()) {
      unmet_.emplace_back("it is no JSON object");
      return false;
    }
    for (const Condition& condition : wish_.conditions) {
      if (auto unmet = vda5050::Unmet(condition, *message)) unmet_.push_back(*std::move(unmet));
    }
    return unmet_.empty();
  }

  void Show(const std::string& payload) const {
    // One line: as the robot wrote it, if it wrote one.
    const bool is_line = payload.find_first_of("\r\n\xEF") == std::string::npos;
    const std::string line = is_line ? payload : base::ToJson(*base::ParseJson(payload));
    if (context_.output.json()) {
      context_.output.Line(line);
    } else {
      context_.output.PeopleLine(fmt::format("{}  {}  {}  {}", Name(), base::Printable(wish_.topic),
                                             base::FormatElapsed(steady_clock::now() - start_),
                                             base::Printable(line)));
    }
  }

  [[nodiscard]] std::string Name() const { return base::Printable(wish_.robot.ToString()); }

  [[nodiscard]] std::string InVain(bool connected) const {
    const std::string topic = base::Printable(wish_.topic);
    const std::string time = base::FormatElapsed(wish_.timeout);
    const std::string away = connected ? "" : "; the broker was out of reach at the end";
    if (!came_) return fmt::format("{}: no {} message came within {}{}", Name(), topic, time, away);
    return fmt::format("{}: not so within {}: in its last {} message {}{}", Name(), time, topic,
                       base::Join(unmet_, ", "), away);
  }

  const Wish& wish_;
  const Context& context_;
  steady_clock::time_point start_;
  bool came_ = false;
  std::vector<std::string> unmet_;  ///< of the last message
};

Result<ExitCode> RunAwait(const Options& o, const Context& context) {
  const auto wish = WishOf(o, context.config);
  if (!wish) return Fail(wish.error());
  WarnOfTopic(wish->topic, context.output);
  return Awaiter(*wish, context).Run();
}

}  // namespace

Run DeclareAwait(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  set.AddOption("target", options->target, "The robot: manufacturer/serialNumber, or its alias")
      ->type_name("TARGET");
  set.AddOption("topic", options->topic, "state, connection, factsheet ...")->type_name("TOPIC");
  set.AddOption("conditions", options->conditions, "What one message must say")
      ->type_name("CONDITION");
  set.AddOption("-W,--timeout", options->timeout, "How long to wait [10m]")
      ->type_name("TIME")
      ->group("Waiting");
  set.AddOption("--vda", options->vda.version,
                "Listen to this version's topic only [auto: whichever the robot uses]")
      ->type_name("V")
      ->envname("FLEETPUB_VDA")
      ->group("VDA 5050");
  DeclareTopicOptions(set, options->vda);
  return [options](const Context& context) { return RunAwait(*options, context); };
}

}  // namespace fleetpub::cli
