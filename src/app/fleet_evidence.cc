#include "app/fleet_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "base/json.h"
#include "base/text.h"

namespace fleetpub::app {
namespace {

using std::chrono::nanoseconds;
using vda5050::MessageHeader;

constexpr std::size_t kMostKept = 4;

constexpr auto kHeaderMembers =
    std::to_array<std::string_view>({"/version", "/manufacturer", "/serialNumber", "/timestamp"});

FactsheetEvidence ReadFactsheetEvidence(const Result<base::JsonDocument>& message) {
  FactsheetEvidence evidence;
  if (!message) {
    evidence.fault = message.error().message;
    return evidence;
  }
  evidence.actions = vda5050::ReadFactsheet(*message).actions.size();
  const auto* const limits = base::FindMember(*message, "protocolLimits");
  const auto* const timing = limits == nullptr ? nullptr : base::FindMember(*limits, "timing");
  const auto usual =
      timing == nullptr ? std::nullopt : base::NumberMember(*timing, "defaultStateInterval");
  if (usual && *usual > 0 && *usual < 1e6) {
    evidence.usual_interval = nanoseconds(std::llround(*usual * 1e9));
  }
  return evidence;
}

// `INSTANT_ACTION_STATES_FULL`, and what others make of it.
bool SaysFull(std::string_view error_type) {
  const std::string type = base::ToLower(error_type);
  return type.find("action") != std::string::npos && type.ends_with("full");
}

}  // namespace

void HeaderIds::Take(std::optional<std::uint64_t> id) {
  if (!id) {
    ++missing;
    return;
  }
  ++messages;
  if (before_fall && *id > *before_fall) {
    if (*id - *before_fall <= 2 && *id - *last > 1) ++resumed;
    before_fall.reset();
  } else if (last && *id > *last) {
    skipped += static_cast<std::size_t>(*id - *last - 1);
  }
  if (last && *id == *last) ++repeated;
  const bool wraps = last == UINT32_MAX && *id == 0;
  if (last && *id < *last && !wraps) {
    ++falls;
    if (!before_fall) before_fall = last;
  }
  last = id;
}

void Rhythm::Take(nanoseconds elapsed, nanoseconds since) {
  longest = FindSilence(elapsed, since);
  last = elapsed;
}

nanoseconds Rhythm::FindSilence(nanoseconds end, nanoseconds since) const {
  return std::max(longest, end - std::max(last, since));
}

void Clock::Take(const MessageHeader& header, base::WallTime ours) {
  const auto theirs = vda5050::ReadTime(header);
  if (!theirs) return;
  const nanoseconds difference = *theirs - ours;
  if (!offset || std::chrono::abs(difference) < std::chrono::abs(*offset)) offset = difference;
  if (last && *theirs < *last) ++backwards;
  last = theirs;
}

const TopicEvidence* PlaceEvidence::Find(const std::string& topic_name) const {
  const auto found = topics.find(topic_name);
  return found == topics.end() ? nullptr : &found->second;
}

bool PlaceEvidence::IsOnline() const {
  return connection && connection->connection_state == "ONLINE";
}

bool PlaceEvidence::SendsStates() const {
  const TopicEvidence* const state = Find("state");
  return state != nullptr && state->live > 0;
}

void FleetEvidence::Validate(const mqtt::Message& message, TopicEvidence& evidence) const {
  const auto result = conformance_->Validate(message.topic, message.payload);
  if (!result) return;
  if (!result->version.empty() && evidence.versions.size() < kMostKept) {
    evidence.versions.insert(result->version);
  }
  const auto is_of_header = [&](const schema::Violation& fault) {
    const bool is_one =
        std::find(kHeaderMembers.begin(), kHeaderMembers.end(), fault.path) != kHeaderMembers.end();
    if (is_one) evidence.header_faults.try_emplace(fault.path, fault.message);
    return is_one;
  };
  const schema::Violation* first = nullptr;
  for (const auto& fault : result->findings.errors) {
    if (!is_of_header(fault) && first == nullptr) first = &fault;
  }
  for (const auto& fault : result->findings.warnings) static_cast<void>(is_of_header(fault));
  if (first == nullptr || evidence.invalid++ > 0) return;
  evidence.violation = (first->path.empty() ? "" : first->path + ": ") + first->message;
}

void FleetEvidence::Take(const mqtt::Message& message, const vda5050::TopicLevels& levels,
                         const Arrival& arrival) {
  PlaceEvidence& place = robots_[levels.robot][levels.Place()];
  place.levels = levels;
  TopicEvidence& evidence = place.topics[levels.topic_name];
  evidence.topic = message.topic;
  if (message.payload.empty()) {  // with which a retained message is deleted
    evidence.is_retained = false;
    if (levels.topic_name == "connection") place.connection.reset();
    if (levels.topic_name == "factsheet") place.factsheet.reset();
    return;
  }
  if (message.retained) evidence.is_retained = true;
  const std::size_t payload = std::hash<std::string>()(message.payload);
  const bool is_same = evidence.last_payload == payload;
  if (message.retained && is_same) return;  // comes again with each new connection
  if (!message.retained) {
    ++evidence.live;
    evidence.rhythm.Take(arrival.elapsed, place.since);
    if (levels.topic_name == "connection") place.since = arrival.elapsed;
  }
  evidence.last_payload = payload;
  const auto said = vda5050::ReadMessage(message.payload);
  if (message.retained) {
    retained_.emplace_back(message, &evidence);
  } else {
    Validate(message, evidence);
  }
  if (levels.topic_name == "factsheet") place.factsheet = ReadFactsheetEvidence(said);
  if (!said) return;
  const MessageHeader header = vda5050::ReadHeader(*said);
  if (header.serial_number.empty()) {
    evidence.header_faults.try_emplace("/serialNumber", "is empty");
  }
  if (!is_same && !message.retained) {
    evidence.ids.Take(header.count);
    // A last will is dated when the robot connected.
    if (levels.topic_name != "connection") evidence.clock.Take(header, arrival.at);
  }
  if (levels.topic_name == "connection") place.connection = vda5050::ReadConnection(*said);
  if (levels.topic_name != "state" || message.retained) return;
  place.full_lists.clear();
  for (const auto& error : vda5050::ReadState(*said).errors) {
    if (SaysFull(error.type) && place.full_lists.size() < kMostKept)
      place.full_lists.insert(error.type);
  }
}

void FleetEvidence::ValidateRetained() {
  for (auto& [message, evidence] : std::exchange(retained_, {})) Validate(message, *evidence);
}

void FleetEvidence::Resume(nanoseconds elapsed) {
  for (auto& [robot, places] : robots_) {
    for (auto& [name, place] : places) {
      place.since = elapsed;
      for (auto& [topic_name, topic] : place.topics) {
        topic.ids.last.reset();
        topic.ids.before_fall.reset();
      }
    }
  }
}

}  // namespace fleetpub::app
