#include "vda5050/reports/live_state.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace fleetpub::vda5050 {
namespace {

constexpr std::size_t kMostKept = std::size_t{20} << 20;
// Up to here states are kept whole.
constexpr std::size_t kMostWhole = kMostKept / 2;
// How much of a text is left when it was more.
constexpr std::size_t kLongestWhenFull = 64;
constexpr std::size_t kShort = 512;  // of one robot, for which there is always room
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

std::size_t CountBytes(const std::vector<ActionState>& actions) {
  std::size_t size = 0;
  for (const ActionState& action : actions) {
    size += sizeof action + action.id.size() + action.type.size() + action.status.size() +
            action.result.size();
  }
  return size;
}

std::size_t CountBytes(const RobotState& state) {
  std::size_t size = state.operating_mode.size() + state.emergency_stop.size() +
                     state.order_id.size() + state.last_node_id.size() +
                     CountBytes(state.action_states) + CountBytes(state.instant_action_states) +
                     CountBytes(state.zone_action_states) + state.nodes.size() * sizeof(NodeState);
  for (const NodeState& node : state.nodes) size += node.id.size();
  if (state.position) size += state.position->map_id.size();
  for (const RobotError& error : state.errors) {
    size += sizeof error + error.type.size() + error.level.size() + error.description.size() +
            error.hint.size();
    for (const ErrorReference& reference : error.references) {
      size += sizeof reference + reference.key.size() + reference.value.size();
    }
  }
  for (const RobotRequest& request : state.requests) {
    size += sizeof request + request.id.size() + request.type.size() + request.status.size() +
            request.zone_id.size() + request.zone_set_id.size() + request.edge_id.size();
  }
  for (const ZoneSetState& zones : state.zone_sets) {
    size += sizeof zones + zones.id.size() + zones.map_id.size() + zones.status.size();
  }
  return size;
}

// What no table shows goes.
void Slim(LiveState& state) {
  state.is_slim = true;
  state.action_states = {};
  state.instant_action_states = {};
  state.zone_action_states = {};
  state.loads = {};
  state.information = {};
  state.zone_sets = {};
  state.nodes = {};
  state.position = {};
  state.last_node_id = {};
  for (RobotError& error : state.errors) {
    error.hint = {};
    error.references = {};
  }
}

void Abridge(LiveState& state) {
  state.is_abridged = true;
  std::vector<RobotError> worst;
  if (const RobotError* const error = WorstError(state.errors)) worst.push_back(*error);
  for (RobotError& error : worst) {
    Cut(error.type, kLongestWhenFull);
    Cut(error.level, kLongestWhenFull);
    Cut(error.description, kLongestWhenFull);
  }
  state.errors_left_out = state.errors.size() - worst.size();
  state.errors = std::move(worst);
  state.requests = {};
  Cut(state.operating_mode, kLongestWhenFull);
  Cut(state.emergency_stop, kLongestWhenFull);
  Cut(state.order_id, kLongestWhenFull);
}

}  // namespace

void StateMemory::Keep(std::shared_ptr<const LiveState>& slot, RobotState state) {
  if (slot) {
    kept_ -= slot->bytes;
    abridged_ -= slot->is_abridged ? 1U : 0U;
  }
  auto kept = std::make_shared<LiveState>();
  static_cast<RobotState&>(*kept) = std::move(state);
  CutHeader(kept->header);
  kept->bytes = CountBytes(*kept);
  if (kept_ + kept->bytes > kMostWhole) {
    Slim(*kept);
    kept->bytes = CountBytes(*kept);
  }
  if (kept->bytes > kShort && kept_ + kept->bytes > kMostKept) {
    Abridge(*kept);
    kept->bytes = CountBytes(*kept);
    ++abridged_;
  }
  kept_ += kept->bytes;
  slot = std::move(kept);
}

void CutHeaderTexts(ConnectionMessage& message) {
  CutHeader(message.header);
  Cut(message.connection_state, kLongestHeaderText);
}

int WeighLevel(std::string_view level) {
  constexpr std::array<std::string_view, 4> kLevels = {"WARNING", "URGENT", "CRITICAL", "FATAL"};
  const auto* const found = std::find(kLevels.begin(), kLevels.end(), level);
  return found == kLevels.end() ? -1 : static_cast<int>(found - kLevels.begin());
}

const RobotError* WorstError(const std::vector<RobotError>& errors) {
  const auto worst =
      std::max_element(errors.begin(), errors.end(), [](const RobotError& a, const RobotError& b) {
        return WeighLevel(a.level) < WeighLevel(b.level);
      });
  return worst == errors.end() ? nullptr : &*worst;
}

}  // namespace fleetpub::vda5050
