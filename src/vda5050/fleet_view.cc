#include "vda5050/fleet_view.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/time.h"

namespace fleetpub::vda5050 {
namespace {

// In the order in which a broker hands them out, so that the state of a robot is mostly there when
// its connection is.
constexpr std::array<std::string_view, 2> kTopics = {"state", "connection"};

constexpr std::size_t kMostFaults = 1'000;  // of robots that nothing else is known of

int WeightOf(std::string_view level) {
  constexpr std::array<std::string_view, 4> kLevels = {"WARNING", "URGENT", "CRITICAL", "FATAL"};
  const auto* const found = std::find(kLevels.begin(), kLevels.end(), level);
  return found == kLevels.end() ? -1 : static_cast<int>(found - kLevels.begin());
}

bool IsNewer(const RobotState& state, const RobotState& than) {
  return base::ParseDateTime(state.header.timestamp) > base::ParseDateTime(than.header.timestamp);
}

}  // namespace

FleetView::FleetView(TopicScheme scheme, std::vector<RobotPattern> patterns)
    : patterns_(std::move(patterns)) {
  base_.topics = std::move(scheme);
  if (patterns_.empty()) patterns_.emplace_back();
}

Result<std::vector<std::string>> FleetView::Filters() const {
  std::vector<std::string> filters;
  for (const RobotPattern& pattern : patterns_) {
    const auto some = DiscoveryFilters(base_.topics, pattern.Filter(), kTopics);
    if (!some) return Fail(some.error());
    for (const std::string& filter : *some) {
      if (std::find(filters.begin(), filters.end(), filter) == filters.end()) {
        filters.push_back(filter);
      }
    }
  }
  return filters;
}

bool FleetView::IsMeant(const RobotAddress& robot) const {
  return std::any_of(patterns_.begin(), patterns_.end(),
                     [&](const RobotPattern& pattern) { return pattern.Matches(robot); });
}

const RobotView* FleetView::Deliver(std::string_view topic, std::string_view payload,
                                    Origin origin) {
  const auto levels = ReadTopic(base_.topics, topic);
  if (!levels || !IsMeant(levels->robot)) return nullptr;
  const bool is_new = !robots_.contains(levels->robot);
  Entry& entry = robots_[levels->robot];
  entry.view.robot = levels->robot;
  if (const auto fault = is_new ? faults_.extract(levels->robot) : decltype(faults_)::node_type()) {
    entry.view.state_fault = fault.mapped();
  }
  const bool taken = levels->topic_name == "connection" ? TakeConnection(entry, topic, payload)
                     : levels->topic_name == "state"    ? TakeState(entry, topic, payload, origin)
                                                        : false;
  if (taken) return &entry.view;
  const bool has_room = faults_.size() < kMostFaults;
  if (is_new && has_room && !entry.view.state_fault.empty())
    faults_[levels->robot] = entry.view.state_fault;
  if (is_new) robots_.erase(levels->robot);
  return nullptr;
}

bool FleetView::TakeConnection(Entry& entry, std::string_view topic, std::string_view payload) {
  RobotView& view = entry.view;
  auto found = DialectFrom(base_, topic, payload);
  if (found) {
    entry.connections.insert_or_assign(std::string(topic), *std::move(found));
  } else if (!payload.empty() || entry.connections.erase(std::string(topic)) == 0) {
    return false;  // no connection message, or nothing to take back
  }
  std::vector<Discovered> all;
  for (const auto& [of, connection] : entry.connections) all.push_back(connection);
  const auto best = OnePerRobot(std::move(all));
  view.connection_state = best.empty() ? "" : best.front().message.connection_state;
  view.connection_timestamp = best.empty() ? "" : best.front().message.header.timestamp;
  if (!best.empty()) Describe(view, best.front());
  return true;
}

bool FleetView::TakeState(Entry& entry, std::string_view topic, std::string_view payload,
                          Origin origin) {
  RobotView& view = entry.view;
  auto state = ReadState(payload);
  if (!state) {
    if (payload.empty()) return false;
    view.state_fault = state.error().message;
    return !entry.connections.empty() || view.state;
  }
  const bool is_late = origin == Origin::kRetained && view.state && !IsNewer(*state, *view.state);
  if (is_late) return false;
  view.state = *std::move(state);
  view.state_fault.clear();
  if (entry.connections.empty()) {
    if (const auto found = DialectFrom(base_, topic, payload)) Describe(view, *found);
  }
  return true;
}

void FleetView::Describe(RobotView& view, const Discovered& found) const {
  const auto levels = ReadTopic(base_.topics, found.topic);
  view.interface_name =
      base_.topics.interface_name.empty() ? levels->interface_name : base_.topics.interface_name;
  view.topic_level = levels->major;
  view.version = found.dialect ? std::optional(found.dialect->version) : std::nullopt;
  view.header_version = found.message.header.version;
}

std::vector<const RobotView*> FleetView::robots() const {
  std::vector<const RobotView*> views;
  views.reserve(robots_.size());
  for (const auto& [robot, entry] : robots_) views.push_back(&entry.view);
  return views;
}

const RobotError* WorstError(const std::vector<RobotError>& errors) {
  const auto worst =
      std::max_element(errors.begin(), errors.end(), [](const RobotError& a, const RobotError& b) {
        return WeightOf(a.level) < WeightOf(b.level);
      });
  return worst == errors.end() ? nullptr : &*worst;
}

}  // namespace fleetpub::vda5050
