#include "simulator/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/retained.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using vda5050::RobotAddress;
using vda5050::TopicLevels;

constexpr milliseconds kGlance{100};  // between two looks at whether to go on
constexpr std::chrono::seconds kPatience{10};

bool IsIn(std::span<const std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// What a robot leaves at the broker, whether or not the recording could tell.
bool IsRetained(std::string_view topic_name) {
  return topic_name == "connection" || topic_name == "factsheet";
}

const std::string& Or(const std::string& text, const std::string& otherwise) {
  return text == "*" ? otherwise : text;
}

// In whose name a robot's messages are sent; nothing: they are not.
std::optional<RobotAddress> FindName(const ReplayOptions& options, const RobotAddress& robot) {
  if (options.mappings.empty()) return robot;
  for (const RobotMapping& mapping : options.mappings) {
    if (!mapping.from.Matches(robot)) continue;
    return RobotAddress{Or(mapping.manufacturer, robot.manufacturer),
                        Or(mapping.serial_number, robot.serial_number)};
  }
  return std::nullopt;
}

// A message as it is to be sent.
struct Part {
  mqtt::Message message;
  std::string place;  // the robot's connection topic
  std::string topic_name;
  RobotAddress robot;
  bool is_command = false;
  bool is_mapped = false;
};

// Nothing: of another robot, or of a topic that is none of VDA 5050. Errors: ErrorKind::kUsage.
Result<std::optional<Part>> MakePart(const recording::Message& said, const ReplayOptions& options) {
  auto levels = vda5050::ReadTopic(options.scheme, said.topic);
  if (!levels || !IsIn(vda5050::kTopicNames, levels->topic_name)) return std::nullopt;
  const auto robot = FindName(options, levels->robot);
  if (!robot) return std::nullopt;
  Part part;
  part.is_mapped = *robot != levels->robot;
  if (part.is_mapped && !vda5050::IsAddressable(*robot)) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--map: {} is no name of a robot", base::Printable(robot->ToString())));
  }
  levels->robot = *robot;
  auto topic = part.is_mapped ? vda5050::TopicBeside(options.scheme, *levels, levels->topic_name)
                              : Result<std::string>(said.topic);
  if (!topic) return Fail(std::move(topic.error()));
  auto place = vda5050::TopicBeside(options.scheme, *levels, "connection");
  if (!place) return Fail(std::move(place.error()));
  part.place = *std::move(place);
  part.is_command = IsIn(vda5050::kCommandTopics, levels->topic_name);
  part.topic_name = levels->topic_name;
  part.robot = *robot;
  part.message = {
      .topic = *std::move(topic), .payload = said.payload, .qos = static_cast<mqtt::Qos>(said.qos)};
  // A connection message is not to get lost (3.0 §6.2).
  if (part.topic_name == "connection" && said.qos == 0) part.message.qos = mqtt::Qos::kAtLeastOnce;
  return part;
}

// The message with another header; as it is when it is no JSON object. Members keep their order.
std::string Rewrite(const Part& part, std::optional<std::uint32_t> header_id) {
  const auto document = base::ParseJson(part.message.payload, {.exact = true});
  if (!document || !document->IsObject()) return part.message.payload;
  std::string text = "{";
  for (const auto& [name, value] : document->GetObject()) {
    const std::string_view key = base::ToView(name);
    std::string said = base::ToJson(value);
    if (part.is_mapped && key == "manufacturer") said = base::JsonString(part.robot.manufacturer);
    if (part.is_mapped && key == "serialNumber") said = base::JsonString(part.robot.serial_number);
    if (header_id && key == "headerId") said = std::to_string(*header_id);
    if (header_id && key == "timestamp") {
      said = base::JsonString(base::FormatTimestamp(base::WallTime::clock::now()));
    }
    text += fmt::format("{}{}:{}", text.size() == 1 ? "" : ",", base::JsonString(key), said);
  }
  return text + "}";
}

class Player {
 public:
  Player(const ReplayOptions& options, const ReplayPlan& plan, mqtt::RobotTransport& transport)
      : options_(options), plan_(plan), transport_(transport) {}

  Result<Replayed> Run() {
    if (auto ok = CheckPlaces(); !ok) return Fail(std::move(ok.error()));
    auto played = Play();
    const Status settled = options_.keep ? Await() : PutBack();
    if (!played) return Fail(std::move(played.error()));
    if (!settled) return Fail(settled.error());
    return replayed_;
  }

 private:
  // What is retained where messages will be left, and whether the robots' places are free.
  Status CheckPlaces() {
    std::set<std::string> all = plan_.retained;
    all.insert(plan_.places.begin(), plan_.places.end());
    const std::vector<std::string> topics(all.begin(), all.end());
    std::size_t left = topics.size();
    auto read = delivery::ReadRetained(transport_, topics, {}, [&](const mqtt::Message& message) {
      if (message.retained) before_[message.topic] = message.payload;
      return message.retained && --left == 0;
    });
    if (read && topics.size() <= delivery::kFiltersAtOnce) {
      read = transport_.Unsubscribe(topics, steady_clock::now() + kPatience);
    }
    if (!read || options_.force) return read;
    for (const auto& [topic, payload] : before_) {
      const auto connection = vda5050::ReadConnection(payload);
      if (!connection || connection->connection_state != "ONLINE") continue;
      return Fail(
          ErrorKind::kPreflight,
          fmt::format("nothing was sent: a robot is ONLINE at {}, and would be heard in two "
                      "voices: --map gives it another name, --force plays it all the same",
                      base::Printable(topic)));
    }
    return {};
  }

  Status Play() {
    auto reader = recording::Reader::Open(options_.file);
    if (!reader) return Fail(std::move(reader.error()));
    std::optional<microseconds> first;
    const auto start = steady_clock::now();
    for (;;) {
      auto said = reader->NextMessage();
      if (!said) return Fail(std::move(said.error()));
      if (!*said) return {};
      auto part = MakePart(**said, options_);
      if (!part) return Fail(std::move(part.error()));
      if (!*part || ((*part)->is_command && !options_.commands)) continue;
      first = first.value_or((*said)->t);
      // Time that runs backwards in the file has no gap.
      const auto after = std::max((*said)->t - *first, microseconds(0)) / options_.speed;
      const auto due = start + std::chrono::duration_cast<steady_clock::duration>(after);
      auto waited = WaitUntil(due);
      if (!waited) return Fail(std::move(waited.error()));
      replayed_.was_stopped = !*waited;
      if (replayed_.was_stopped) return {};
      if (auto sent = Send(**part); !sent) return sent;
      const auto late = std::chrono::duration_cast<microseconds>(steady_clock::now() - due);
      replayed_.latest = std::max(replayed_.latest, late);
    }
  }

  // False: somebody has stopped it.
  Result<bool> WaitUntil(mqtt::Deadline due) {
    do {
      if (steady_clock::now() >= next_look_) {
        next_look_ = steady_clock::now() + kGlance;
        if (options_.stopped()) return false;
      }
      const auto heard = transport_.Receive(std::min(due, next_look_));
      if (!heard) return Fail(heard.error());
    } while (steady_clock::now() < due);
    return true;
  }

  Status Send(Part& part) {
    const bool is_kept = IsRetained(part.topic_name);
    std::optional<std::uint32_t> header_id;
    if (options_.restamp) header_id = header_ids_[part.message.topic]++;
    if (part.is_mapped || options_.restamp) part.message.payload = Rewrite(part, header_id);
    const auto limit = steady_clock::now() + kPatience;
    const auto sent = is_kept ? transport_.PublishRetained(part.message, limit)
                              : transport_.Publish(part.message, limit);
    if (!sent) return Fail(sent.error());
    if (is_kept) left_.insert(part.message.topic);
    ++replayed_.messages;
    return {};
  }

  Status PutBack() {
    for (const std::string& topic : left_) {
      const auto before = before_.find(topic);
      const auto sent =
          transport_.PublishRetained({.topic = topic,
                                      .payload = before == before_.end() ? "" : before->second,
                                      .qos = mqtt::Qos::kAtLeastOnce},
                                     steady_clock::now() + kPatience);
      if (!sent) return Fail(sent.error());
    }
    return Await();
  }

  Status Await() {
    const auto taken = transport_.AwaitAcknowledgements(steady_clock::now() + kPatience, 0);
    if (!taken) return Fail(taken.error());
    return {};
  }

  const ReplayOptions& options_;
  const ReplayPlan& plan_;
  mqtt::RobotTransport& transport_;
  std::map<std::string, std::string> before_;        // by topic: what was retained
  std::set<std::string> left_;                       // topics on which we left something
  std::map<std::string, std::uint32_t> header_ids_;  // by topic, the next one
  steady_clock::time_point next_look_;
  Replayed replayed_;
};

}  // namespace

Result<RobotMapping> ParseRobotMapping(std::string_view text) {
  const std::size_t sign = text.find('=');
  const std::string_view to = sign == std::string_view::npos ? "" : text.substr(sign + 1);
  const std::size_t slash = to.find('/');
  if (slash == std::string_view::npos) {
    return Fail(ErrorKind::kUsage, fmt::format("--map {}: say which robot becomes which: --map "
                                               "KIT/0001=TEST/0001, --map 'KIT/*=TEST/*'",
                                               base::Printable(text)));
  }
  auto from = vda5050::ParseRobotPattern(text.substr(0, sign));
  if (!from) return Fail(std::move(from.error()));
  RobotMapping mapping{*std::move(from), vda5050::Unescaped(to.substr(0, slash)),
                       vda5050::Unescaped(to.substr(slash + 1))};
  for (const std::string& name : {mapping.manufacturer, mapping.serial_number}) {
    if (name == "*" || vda5050::IsAddressable({name, "0"})) continue;
    return Fail(ErrorKind::kUsage, fmt::format("--map {}: \"{}\" is no name of a robot",
                                               base::Printable(text), base::Printable(name)));
  }
  return mapping;
}

Result<ReplayPlan> PlanReplay(const ReplayOptions& options) {
  if (options.file == "-") {
    return Fail(ErrorKind::kUsage, "replay reads its file twice, and standard input once only");
  }
  auto reader = recording::Reader::Open(options.file);
  if (!reader) return Fail(std::move(reader.error()));
  ReplayPlan plan;
  std::optional<microseconds> first;
  for (;;) {
    auto said = reader->NextMessage();
    if (!said) return Fail(std::move(said.error()));
    if (!*said) break;
    auto part = MakePart(**said, options);
    if (!part) return Fail(std::move(part.error()));
    if (!*part) {
      ++plan.others;
      continue;
    }
    if ((*part)->is_command) ++plan.commands;
    if ((*part)->is_command && !options.commands) continue;
    ++plan.messages;
    plan.robots.insert((*part)->robot);
    plan.places.insert((*part)->place);
    if (IsRetained((*part)->topic_name)) plan.retained.insert((*part)->message.topic);
    first = first.value_or((*said)->t);
    plan.lasts = std::max(plan.lasts, (*said)->t - *first);
  }
  plan.faults = reader->faults();
  if (plan.messages == 0) {
    return Fail(ErrorKind::kPreflight,
                fmt::format("{} has nothing that would be sent: {} messages of other robots or "
                            "topics, {} commands",
                            base::Printable(options.file.string()), plan.others, plan.commands));
  }
  return plan;
}

Result<Replayed> Replay(const ReplayOptions& options, const ReplayPlan& plan,
                        mqtt::RobotTransport& transport) {
  return Player(options, plan, transport).Run();
}

}  // namespace fleetpub::simulator
