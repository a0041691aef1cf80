#include "simulator/fleet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <span>

#include "simulator/factsheet.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::steady_clock;
using vda5050::RobotAddress;

constexpr std::array<std::string_view, 4> kHeard = {"instantActions", "order", "zoneSet",
                                                    "responses"};

// The last two exist from 3.0 on.
std::span<const std::string_view> HeardIn(vda5050::Version version) {
  return std::span(kHeard).first(version >= vda5050::Version::k300 ? 4 : 2);
}

}  // namespace

Result<std::unique_ptr<Fleet>> Fleet::Make(Settings settings,
                                           const std::vector<RobotAddress>& robots,
                                           schema::Registry& registry, EventCallback on_event) {
  std::unique_ptr<Fleet> fleet(new Fleet(std::move(settings), registry, std::move(on_event)));
  fleet->members_.reserve(robots.size());
  for (const RobotAddress& address : robots) {
    if (auto added = fleet->Add(address); !added) return Fail(std::move(added.error()));
  }
  return fleet;
}

Fleet::Fleet(Settings settings, schema::Registry& registry, EventCallback on_event)
    : settings_(std::move(settings)),
      factsheet_(FactsheetBody(settings_)),
      inspector_(settings_, registry),
      on_event_(std::move(on_event)),
      random_(settings_.drop_seed) {}

Status Fleet::Add(const RobotAddress& address) {
  const std::size_t index = members_.size();
  for (const std::string_view topic : HeardIn(settings_.version)) {
    auto full = vda5050::TopicFor(settings_.topics, settings_.version, address, topic);
    if (!full) return Fail(std::move(full.error()));
    if (!destinations_.emplace(*std::move(full), Destination{index, topic}).second) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("two robots would share the topics of {}", address.ToString()));
    }
  }
  const Header header{std::string(vda5050::GetFacts(settings_.version).name), address.manufacturer,
                      address.serial_number};
  members_.push_back(
      {address,
       VirtualRobot({settings_, GetTerms(settings_.version), inspector_, factsheet_}, header)});
  noted_.push_back(steady_clock::time_point::max());
  counted_as_gone_.push_back(false);
  ++present_;
  return {};
}

std::vector<std::string> Fleet::Subscriptions() const {
  std::vector<std::string> topics;
  topics.reserve(destinations_.size());
  for (const auto& [topic, destination] : destinations_) topics.push_back(topic);
  return topics;
}

std::vector<std::string> Fleet::RetainedTopics() const {
  std::vector<std::string> topics;
  for (const std::string_view topic : {"connection", "factsheet"}) {
    if (topic == "factsheet" && factsheet_.empty()) continue;
    for (const Member& member : members_) topics.push_back(MakeTopic(member, topic));
  }
  return topics;
}

mqtt::Will Fleet::MakeWill(std::size_t index, const Moment& now) {
  Member& member = members_[index];
  Utterance will = member.robot.Will(now);
  return {MakeTopic(member, will.topic), std::move(will.payload), will.qos, will.retained};
}

void Fleet::Start(const Moment& now, std::vector<Outgoing>& out) {
  Utterances said;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    members_[i].robot.Start(now, said);
    After(i, said, out);
  }
}

void Fleet::Receive(const mqtt::Message& message, const Moment& now, std::vector<Outgoing>& out) {
  const auto found = destinations_.find(message.topic);
  if (found == destinations_.end()) return;
  if (settings_.drop > 0 && std::uniform_real_distribution<>()(random_) < settings_.drop) return;
  const auto [index, topic] = found->second;
  Member& member = members_[index];
  const std::string name = member.address.ToString();
  const auto on_event = [&](const Event& event) { on_event_(name, event); };
  if (message.retained && !member.robot.gone()) {
    on_event({Event::Kind::kFault,
              fmt::format("{}: a command must not be retained: it would be obeyed again tomorrow",
                          topic)});
  }
  Utterances said;
  member.robot.Receive(topic, message.payload, now, said, on_event);
  After(index, said, out);
}

void Fleet::Tick(const Moment& now, std::vector<Outgoing>& out) {
  Utterances said;
  while (!turns_.empty() && turns_.top().due <= now.steady) {
    const Turn turn = turns_.top();
    turns_.pop();
    if (turn.due != noted_[turn.index]) continue;  // it was called earlier
    noted_[turn.index] = steady_clock::time_point::max();
    members_[turn.index].robot.Tick(now, said);
    After(turn.index, said, out);
  }
}

void Fleet::End(const Moment& now, std::vector<Outgoing>& out) {
  Utterances said;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    members_[i].robot.End(now, said);
    After(i, said, out);
  }
}

steady_clock::time_point Fleet::Due() {
  while (!turns_.empty() && turns_.top().due != noted_[turns_.top().index]) turns_.pop();
  return turns_.empty() ? steady_clock::time_point::max() : turns_.top().due;
}

void Fleet::After(std::size_t index, Utterances& said, std::vector<Outgoing>& out) {
  const Member& member = members_[index];
  if (member.robot.gone() && !counted_as_gone_[index]) {
    counted_as_gone_[index] = true;
    --present_;
  }
  for (Utterance& one : said) {
    out.push_back({{MakeTopic(member, one.topic), std::move(one.payload), one.qos}, one.retained});
  }
  said.clear();
  const auto due = member.robot.Due();
  if (due < noted_[index]) {
    noted_[index] = due;
    turns_.push({due, index});
  }
}

std::string Fleet::MakeTopic(const Member& member, std::string_view topic) const {
  auto full = vda5050::TopicFor(settings_.topics, settings_.version, member.address, topic);
  return full ? *std::move(full) : std::string();  // Add() has tried; only the last level differs
}

Result<std::vector<RobotAddress>> CountUp(const RobotAddress& first, std::size_t count) {
  if (count == 1) return std::vector{first};
  const std::string& serial = first.serial_number;
  const auto digits = serial.find_last_not_of("0123456789") + 1;
  std::uint64_t number = 0;
  const auto [end, error] =
      std::from_chars(serial.data() + digits, serial.data() + serial.size(), number);
  if (error != std::errc()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--count counts up the number at the end of the serial number, and {} "
                            "has none: name it such as KIT/0001",
                            first.ToString()));
  }
  std::vector<RobotAddress> robots;
  robots.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    robots.push_back({first.manufacturer, fmt::format("{}{:0{}}", serial.substr(0, digits),
                                                      number + i, serial.size() - digits)});
  }
  return robots;
}

}  // namespace fleetpub::simulator
