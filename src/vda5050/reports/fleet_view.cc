#include "vda5050/reports/fleet_view.h"

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

// What robots may say at any length, all of them together; and how much of a text is left when it
// was more.
constexpr std::size_t kMostKept = std::size_t{20} << 20;
constexpr std::size_t kLongestWhenFull = 64;
constexpr std::size_t kShort = 512;  // of one robot, for which there is always room
// Of what is short in every message that means well.
constexpr std::size_t kLongestHeaderText = 256;

void Cut(std::string& text, std::size_t longest) {
  if (text.size() > longest) text = Shown(text, longest);
}

void CutHeader(MessageHeader& header) {
  for (std::string* const text :
       {&header.timestamp, &header.version, &header.manufacturer, &header.serial_number}) {
    Cut(*text, kLongestHeaderText);
  }
}

// Only what somebody asks a FleetView for.
RobotState Slimmed(RobotState state) {
  CutHeader(state.header);
  state.action_states = {};
  state.instant_action_states = {};
  state.zone_sets = {};
  state.position = {};
  state.last_node_id = {};
  for (RobotError& error : state.errors) {
    error.hint = {};
    error.references = {};
  }
  return state;
}

std::size_t SizeOf(const RobotState& state) {
  std::size_t size = state.operating_mode.size() + state.order_id.size();
  for (const RobotError& error : state.errors) {
    size += sizeof error + error.type.size() + error.level.size() + error.description.size();
  }
  for (const RobotRequest& request : state.requests) {
    size += sizeof request + request.id.size() + request.type.size() + request.status.size() +
            request.zone_id.size() + request.zone_set_id.size() + request.edge_id.size();
  }
  return size;
}

// The errors that are left out.
std::size_t Abridge(RobotState& state) {
  std::vector<RobotError> worst;
  if (const RobotError* const error = WorstError(state.errors)) worst.push_back(*error);
  for (RobotError& error : worst) {
    Cut(error.type, kLongestWhenFull);
    Cut(error.level, kLongestWhenFull);
    Cut(error.description, kLongestWhenFull);
  }
  const std::size_t left_out = state.errors.size() - worst.size();
  state.errors = std::move(worst);
  state.requests = {};
  Cut(state.operating_mode, kLongestWhenFull);
  Cut(state.order_id, kLongestWhenFull);
  return left_out;
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
  auto message = ReadConnection(payload);
  if (message) {
    CutHeader(message->header);
    Cut(message->connection_state, kLongestHeaderText);
  }
  auto found = message ? DialectFrom(base_, topic, *std::move(message)) : std::nullopt;
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
  Keep(entry, Slimmed(*std::move(state)));
  view.state_fault.clear();
  if (entry.connections.empty()) {
    if (const auto found = DialectFrom(base_, topic, payload)) Describe(view, *found);
  }
  return true;
}

void FleetView::Keep(Entry& entry, RobotState state) {
  kept_ -= entry.kept;
  abridged_ -= entry.is_abridged ? 1 : 0;
  entry.kept = SizeOf(state);
  entry.is_abridged = entry.kept > kShort && kept_ + entry.kept > kMostKept;
  entry.view.errors_left_out = 0;
  if (entry.is_abridged) {
    entry.view.errors_left_out = Abridge(state);
    entry.kept = SizeOf(state);
    ++abridged_;
  }
  kept_ += entry.kept;
  entry.view.state = std::move(state);
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
