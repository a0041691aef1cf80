#include "simulator/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "delivery/reconnect.h"
#include "delivery/retained.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using vda5050::RobotAddress;
using vda5050::TopicLevels;

constexpr milliseconds kGlance{100};  // between two looks at whether to go on
constexpr std::chrono::seconds kPatience{10};
constexpr auto kKept = mqtt::Qos::kAtLeastOnce;  // for what is to be retained

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
  RobotAddress recorded;  // whose message it was
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
  part.recorded = std::exchange(levels->robot, *robot);
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
  Player(const ReplayOptions& options, const ReplayPlan& plan,
         std::unique_ptr<mqtt::RobotTransport> transport, const ReplayHooks& hooks)
      : options_(options), plan_(plan), transport_(std::move(transport)), hooks_(hooks) {}

  Result<Replayed> Run() {
    if (auto ok = CheckPlaces(); !ok) return Fail(std::move(ok.error()));
    schedule_.Connected(steady_clock::now());
    auto played = Play();
    const Status finished = Finish();
    if (transport_ != nullptr) transport_->Disconnect();
    if (!played) return Fail(std::move(played.error()));
    if (!finished) return Fail(finished.error());
    return replayed_;
  }

 private:
  // What the broker has to acknowledge.
  struct Sent {
    int token;
    mqtt::Message message;
    bool is_kept;
  };
  // What it would not take.
  struct Untaken {
    std::uint64_t refused = 0;
    std::uint64_t unacknowledged = 0;
    std::string first;  // that was refused, and why
  };

  // What is retained where messages will be left, and whether the robots' places are free.
  Status CheckPlaces() {
    std::set<std::string> all = plan_.retained;
    all.insert(plan_.places.begin(), plan_.places.end());
    auto found = ReadKept({all.begin(), all.end()});
    if (!found) return Fail(std::move(found.error()));
    before_ = *std::move(found);
    if (options_.force) return {};
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

  // By topic, what the broker keeps there.
  Result<std::map<std::string, std::string>> ReadKept(const std::vector<std::string>& topics) {
    std::map<std::string, std::string> kept;
    if (topics.empty()) return kept;
    std::size_t left = topics.size();
    auto read =
        delivery::ReadRetained(*transport_, topics, {.keep = 0}, [&](const mqtt::Message& message) {
          if (message.retained) kept[message.topic] = message.payload;
          return message.retained && --left == 0;
        });
    if (!read) return Fail(std::move(read.error()));
    return kept;
  }

  Status Play() {
    auto reader = recording::Reader::Open(options_.file);
    if (!reader) return Fail(std::move(reader.error()));
    std::optional<microseconds> first;
    start_ = steady_clock::now();
    while (true) {
      auto said = reader->NextMessage();
      if (!said) return Fail(std::move(said.error()));
      if (!*said) return {};
      auto part = MakePart(**said, options_);
      if (!part) return Fail(std::move(part.error()));
      if (!*part || ((*part)->is_command && !options_.commands)) continue;
      first = first.value_or((*said)->t);
      // Time that runs backwards in the file has no gap.
      const auto since = std::max((*said)->t - *first, microseconds(0)) / options_.speed;
      const auto after = std::chrono::duration_cast<steady_clock::duration>(since);
      if (!WaitUntil(after)) return {};
      if (auto sent = Send(**part); !sent) return replayed_.was_stopped ? Status() : sent;
      const auto late = duration_cast<microseconds>(steady_clock::now() - start_ - after);
      replayed_.latest = std::max(replayed_.latest, late);
    }
  }

  // So long behind the start, which comes later when the connection is lost. False: somebody has
  // stopped it.
  bool WaitUntil(steady_clock::duration after) {
    do {
      if (steady_clock::now() >= next_look_) {
        next_look_ = steady_clock::now() + kGlance;
        replayed_.was_stopped = options_.stopped();
        if (replayed_.was_stopped) return false;
      }
      const auto heard = transport_->Receive(std::min(start_ + after, next_look_));
      if (!heard && !ConnectAgain(heard.error())) return false;
      // That it is lost, the next call of any other kind tells, too.
      static_cast<void>(NoteAcknowledgements(steady_clock::now()));
    } while (steady_clock::now() < start_ + after);
    return true;
  }

  Status Send(Part& part) {
    const bool is_kept = IsRetained(part.topic_name);
    std::optional<std::uint32_t> header_id;
    if (options_.restamp) header_id = header_ids_[part.message.topic]++;
    if (part.is_mapped || options_.restamp) part.message.payload = Rewrite(part, header_id);
    if (is_kept) left_[part.message.topic] = part.message.payload;
    ++replayed_.messages;
    return Publish(part.message, is_kept);
  }

  // Over one connection after the other, until it has left. Errors: the broker would never take it, or
  // somebody has stopped it while there was none.
  Status Publish(const mqtt::Message& message, bool is_kept) {
    while (true) {
      if (auto ok = transport_->Admits(message.topic, message.payload.size(), message.qos); !ok) {
        return ok;
      }
      const auto limit = steady_clock::now() + kPatience;
      const auto token = is_kept ? transport_->PublishRetained(message, limit)
                                 : transport_->Publish(message, limit);
      if (token && message.qos != mqtt::Qos::kAtMostOnce) {
        sent_.push_back({*token, message, is_kept});
      }
      if (token) return {};
      if (!ConnectAgain(token.error())) return Fail(token.error());
    }
  }

  // Until all of them are there, or the deadline. Errors: the connection is lost.
  Status NoteAcknowledgements(mqtt::Deadline deadline) {
    if (sent_.empty()) return {};
    const auto acknowledged = transport_->AwaitAcknowledgements(deadline, 0);
    if (!acknowledged) return Fail(acknowledged.error());
    for (const mqtt::Acknowledgement& one : *acknowledged) {
      const auto sent = std::find_if(sent_.begin(), sent_.end(), [&](const Sent& candidate) {
        return candidate.token == one.token;
      });
      if (sent == sent_.end()) continue;
      if (one.Refused() && untaken_.refused++ == 0) {
        untaken_.first = fmt::format("{}: {}", base::Printable(sent->message.topic), one.reason);
      }
      sent_.erase(sent);
    }
    return {};
  }

  // For as long as some come in time. Errors: the connection is lost, and somebody has stopped it.
  Status AwaitAll() {
    for (std::size_t before = 0; !sent_.empty() && sent_.size() != before;) {
      before = sent_.size();
      const auto noted = NoteAcknowledgements(steady_clock::now() + kPatience);
      if (noted) continue;
      if (replayed_.was_stopped || !ConnectAgain(noted.error())) {
        return Fail(noted.error());
      }
      before = 0;
    }
    untaken_.unacknowledged += std::exchange(sent_, {}).size();
    return {};
  }

  // The recording stands still until there is a connection. False: somebody has stopped it.
  bool ConnectAgain(const Error& error) {
    static_cast<void>(NoteAcknowledgements(steady_clock::now()));
    const auto lost_at = steady_clock::now();
    hooks_.lost(error);
    schedule_.Lost(lost_at);
    transport_.reset();
    while (transport_ == nullptr) {
      std::this_thread::sleep_until(std::min(schedule_.next(), steady_clock::now() + kGlance));
      replayed_.was_stopped = options_.stopped();
      if (replayed_.was_stopped) return false;
      if (steady_clock::now() >= schedule_.next()) TryToConnect();
    }
    const auto lasted = steady_clock::now() - lost_at;
    start_ += lasted;
    ++replayed_.losses;
    replayed_.lost += duration_cast<microseconds>(lasted);
    hooks_.again(duration_cast<microseconds>(lasted));
    return true;
  }

  // A connection over which all has been said again that has to be.
  void TryToConnect() {
    if (auto opened = hooks_.open()) transport_ = *std::move(opened);
    if (transport_ == nullptr || !SayAgain()) {
      transport_.reset();
      return schedule_.Failed(steady_clock::now());
    }
    schedule_.Connected(steady_clock::now());
  }

  // What the broker may never have had, and what it had and has kept no more.
  Status SayAgain() {
    std::vector<std::string> topics;
    for (const auto& [topic, payload] : left_) topics.push_back(topic);
    const auto kept = ReadKept(topics);
    if (!kept) return Fail(kept.error());
    std::vector<Sent> again = sent_;
    for (const auto& left : left_) {
      const auto is_it = [&](const Sent& sent) { return sent.message.topic == left.first; };
      if (kept->contains(left.first) || std::any_of(again.begin(), again.end(), is_it)) continue;
      again.push_back({0, {.topic = left.first, .payload = left.second, .qos = kKept}, true});
    }
    sent_.clear();
    for (std::size_t i = 0; i < again.size(); ++i) {
      auto& [token, message, is_kept] = again[i];
      const auto limit = steady_clock::now() + kPatience;
      const auto published = is_kept ? transport_->PublishRetained(message, limit)
                                     : transport_->Publish(message, limit);
      if (!published) {
        sent_.insert(sent_.end(), again.begin() + static_cast<std::ptrdiff_t>(i), again.end());
        return Fail(published.error());
      }
      ++replayed_.again;
      sent_.push_back({*published, message, is_kept});
    }
    return {};
  }

  // All of it is with the broker, and nothing is left there that was not before.
  Status Finish() {
    std::map<std::string, std::string> left;
    if (!options_.keep) left = std::exchange(left_, {});
    if (transport_ == nullptr) {
      if (options_.keep ? sent_.empty() : left.empty()) return {};
      auto opened = hooks_.open();
      if (!opened) return Fail(std::move(opened.error()));
      transport_ = *std::move(opened);
      // What was there before takes their place.
      if (!options_.keep) std::erase_if(sent_, [](const Sent& sent) { return sent.is_kept; });
      if (auto said = SayAgain(); !said) return said;
    }
    if (auto ended = AwaitAll(); !ended) return ended;
    const Untaken said = std::exchange(untaken_, {});
    for (const auto& [topic, payload] : left) {
      const auto before = before_.find(topic);
      auto sent = Publish(
          {.topic = topic, .payload = before == before_.end() ? "" : before->second, .qos = kKept},
          true);
      if (!sent) return sent;
    }
    if (auto ended = AwaitAll(); !ended) return ended;
    return CheckTaken(said, untaken_);
  }

  // Of what was said, and of what was put back. Errors: the broker did not take all of it.
  [[nodiscard]] Status CheckTaken(const Untaken& said, const Untaken& back) const {
    std::vector<std::string> faults;
    const std::string all = base::Counted(replayed_.messages + replayed_.again, "message");
    if (said.refused > 0) {
      faults.push_back(fmt::format("refused {} of {} ({})", said.refused, all, said.first));
    }
    if (said.unacknowledged > 0) {
      faults.push_back(fmt::format("did not acknowledge {} of {}", said.unacknowledged, all));
    }
    if (const auto count = back.refused + back.unacknowledged; count > 0) {
      faults.push_back(fmt::format("did not take back what it had retained before at {}",
                                   base::Counted(count, "topic")));
    }
    if (faults.empty()) return {};
    return Fail(ErrorKind::kBroker,
                fmt::format("{} {}: look at its access list",
                            transport_->server().broker.ToString(), base::Join(faults, ", and ")));
  }

  const ReplayOptions& options_;
  const ReplayPlan& plan_;
  std::unique_ptr<mqtt::RobotTransport> transport_;  // null while it is lost
  const ReplayHooks& hooks_;
  delivery::ReconnectSchedule schedule_;
  std::vector<Sent> sent_;                           // and not acknowledged
  Untaken untaken_;                                  // of what was waited for
  std::map<std::string, std::string> before_;        // by topic: what was retained
  std::map<std::string, std::string> left_;          // likewise: what we left
  std::map<std::string, std::uint32_t> header_ids_;  // by topic, the next one
  steady_clock::time_point start_;                   // of the recording
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
  std::map<RobotAddress, RobotAddress> recorded;  // by the name that each gets
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
    const auto& whose = recorded.emplace((*part)->robot, (*part)->recorded).first->second;
    if (whose != (*part)->recorded) {
      return Fail(ErrorKind::kUsage, fmt::format("--map: {} and {} would both be {}: give each a "
                                                 "name of its own",
                                                 base::Printable(whose.ToString()),
                                                 base::Printable((*part)->recorded.ToString()),
                                                 base::Printable((*part)->robot.ToString())));
    }
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
                        std::unique_ptr<mqtt::RobotTransport> transport, const ReplayHooks& hooks) {
  return Player(options, plan, std::move(transport), hooks).Run();
}

}  // namespace fleetpub::simulator
