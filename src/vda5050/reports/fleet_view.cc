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

int WeighLevel(std::string_view level) {
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
  state.zone_action_states = {};
  state.loads = {};
  state.information = {};
  state.zone_sets = {};
  state.position = {};
  state.last_node_id = {};
  for (RobotError& error : state.errors) {
    error.hint = {};
    error.references = {};
  }
  return state;
}

std::size_t CountBytes(const RobotState& state) {
  std::size_t size =
      state.operating_mode.size() + state.emergency_stop.size() + state.order_id.size();
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
  Cut(state.emergency_stop, kLongestWhenFull);
  Cut(state.order_id, kLongestWhenFull);
  return left_out;
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
  const bool taken =
      levels->topic_name == "connection" ? TakeConnection(entry, topic, payload, origin)
      : levels->topic_name == "state"    ? TakeState(entry, topic, *levels, payload, origin)
                                         : false;
  if (taken) return &entry.view;
  const bool has_room = faults_.size() < kMostFaults;
  if (is_new && has_room && !entry.view.state_fault.empty())
    faults_[levels->robot] = entry.view.state_fault;
  if (is_new) robots_.erase(levels->robot);
  return nullptr;
}

bool FleetView::TakeConnection(Entry& entry, std::string_view topic, std::string_view payload,
                               Origin origin) {
  auto read = ReadConnection(payload);
  ConnectionMessage message =
      read ? *std::move(read) : ConnectionMessage{.fault = read.error().message};
  CutHeader(message.header);
  Cut(message.connection_state, kLongestHeaderText);
  auto found = payload.empty() ? std::nullopt : DialectFrom(base_, topic, std::move(message));
  if (found) {
    const bool is_live = origin == Origin::kLive;
    if (is_live && found->place == entry.live_place && IsAway(found->message.connection_state)) {
      entry.live_place.clear();
    }
    entry.has_begun_anew = entry.has_begun_anew || is_live;
    entry.connections.insert_or_assign(std::string(topic), *std::move(found));
  } else if (!payload.empty() || entry.connections.erase(std::string(topic)) == 0) {
    return false;  // no connection message, or nothing to take back
  }
  Choose(entry, std::nullopt);
  return true;
}

// Decides which place is shown: where it speaks, else the best connection. `speaker` is a state from
// a place without a connection message.
void FleetView::Choose(Entry& entry, const std::optional<Discovered>& speaker) {
  RobotView& view = entry.view;
  std::optional<Discovered> chosen = speaker;
  std::vector<Discovered> all;
  for (const auto& [of, connection] : entry.connections) {
    if (connection.place == entry.live_place) chosen = connection;
    all.push_back(connection);
  }
  if (!chosen && !entry.live_place.empty() && view.state) return;  // it goes on speaking
  if (!chosen && !all.empty()) chosen = OnePerRobot(std::move(all)).front();
  const bool is_connection = chosen && chosen->topic_name == "connection";
  view.connection_state = is_connection ? chosen->message.connection_state : "";
  view.connection_timestamp = is_connection ? chosen->message.header.timestamp : "";
  view.connection_fault = is_connection ? chosen->message.fault : "";
  if (!chosen) return;
  if (chosen->place != view.place) DropState(entry);
  Describe(view, *chosen);
  view.also_at.clear();
  for (const auto& [of, other] : entry.connections) {
    const bool is_online = other.message.connection_state == "ONLINE";
    if (is_online && other.place != view.place) view.also_at = other.place;
  }
}

bool FleetView::TakeState(Entry& entry, std::string_view topic, const TopicLevels& levels,
                          std::string_view payload, Origin origin) {
  RobotView& view = entry.view;
  if (payload.empty()) return false;
  if (origin == Origin::kRetained) {
    const auto found = DialectFrom(base_, topic, payload);
    if (!found || !entry.connections.empty() || view.state) return false;
    Describe(view, *found);
    return true;
  }
  const std::string place = levels.Place();
  if (entry.live_place.empty()) entry.live_place = place;
  if (entry.live_place != place) {
    view.also_at = place;
    return false;
  }
  auto state = ReadState(payload);
  if (!state) {
    view.state_fault = state.error().message;
    return !entry.connections.empty() || view.state;
  }
  const bool is_late = view.state && !std::exchange(entry.has_begun_anew, false) &&
                       IsBefore(state->header, view.state->header);
  if (is_late) return false;
  view.state_fault.clear();
  const bool is_connected =
      std::any_of(entry.connections.begin(), entry.connections.end(),
                  [&](const auto& each) { return each.second.place == place; });
  if (!is_connected) {
    Choose(entry, DialectFrom(base_, topic, ConnectionMessage{.header = state->header}));
  } else if (view.place != place) {
    Choose(entry, std::nullopt);
  }
  Keep(entry, Slimmed(*std::move(state)));
  return true;
}

void FleetView::DropState(Entry& entry) {
  kept_ -= std::exchange(entry.kept, 0);
  abridged_ -= std::exchange(entry.is_abridged, false) ? 1U : 0U;
  entry.view.state.reset();
  entry.view.state_fault.clear();
  entry.view.errors_left_out = 0;
}

void FleetView::Keep(Entry& entry, RobotState state) {
  DropState(entry);
  entry.kept = CountBytes(state);
  entry.is_abridged = entry.kept > kShort && kept_ + entry.kept > kMostKept;
  if (entry.is_abridged) {
    entry.view.errors_left_out = Abridge(state);
    entry.kept = CountBytes(state);
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
  view.place = levels->Place();
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
        return WeighLevel(a.level) < WeighLevel(b.level);
      });
  return worst == errors.end() ? nullptr : &*worst;
}

}  // namespace fleetpub::vda5050
