#include "vda5050/reports/robot_directory.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/json.h"

namespace fleetpub::vda5050 {
namespace {

// So many makes are remembered; robots of further ones share nothing.
constexpr std::size_t kMakes = 16;

template <class T, class Same>
std::shared_ptr<const T> Shared(std::vector<std::shared_ptr<const T>>& known, T one,
                                const Same& same) {
  const auto found = std::find_if(known.begin(), known.end(),
                                  [&](const auto& other) { return same(*other, one); });
  if (found != known.end()) return *found;
  auto shared = std::make_shared<const T>(std::move(one));
  if (known.size() < kMakes) known.push_back(shared);
  return shared;
}

RobotPlace& PlaceIn(RobotEntry& entry, const std::string& name) {
  RobotPlace& best = entry;
  if (best.place.empty()) best.place = name;
  if (best.place == name) return best;
  const auto found = std::find_if(entry.others.begin(), entry.others.end(),
                                  [&](const RobotPlace& other) { return other.place == name; });
  if (found != entry.others.end()) return *found;
  return entry.others.emplace_back(RobotPlace{.place = name});
}

std::string_view FirstLevel(std::string_view path) {
  if (path.starts_with('/')) path.remove_prefix(1);
  return path.substr(0, path.find('/'));
}

}  // namespace

std::string_view FindTopicName(const Condition& condition) {
  // Which every message has stand in the one that is always there.
  constexpr std::array<std::string_view, 4> kConnection = {"connectionState", "version",
                                                           "manufacturer", "serialNumber"};
  constexpr std::array<std::string_view, 9> kFactsheet = {
      "typeSpecification", "physicalParameters", "protocolLimits",
      "protocolFeatures",  "agvGeometry",        "mobileRobotGeometry",
      "loadSpecification", "vehicleConfig",      "mobileRobotConfiguration"};
  const auto is_among = [level = FirstLevel(condition.path)](const auto& names) {
    return std::find(names.begin(), names.end(), level) != names.end();
  };
  if (is_among(kConnection)) return "connection";
  return is_among(kFactsheet) ? "factsheet" : "state";
}

bool RobotEntry::IsOnline() const { return connection && connection->connection_state == "ONLINE"; }

bool RobotEntry::IsAlive() const {
  const bool hibernates = connection && connection->connection_state == "HIBERNATING";
  return IsOnline() || (speaks && !hibernates);
}

const RobotPlace* RobotEntry::Rival() const {
  const auto rival = std::find_if(others.begin(), others.end(), [&](const RobotPlace& other) {
    return IsOnline() && other.standing.rank == standing.rank &&
           other.standing.is_live == standing.is_live;
  });
  return rival == others.end() ? nullptr : &*rival;
}

KnownRobot RobotEntry::Known() const {
  const RobotPlace* rival = Rival();
  return {.connection = connection,
          .topic = topic,
          .said_version = said_version,
          .speaks = speaks,
          .other_topic = rival == nullptr ? "" : rival->topic,
          .factsheet = factsheet,
          .factsheet_fault = factsheet_fault,
          .operating_mode = operating_mode};
}

void RobotDirectory::Add(const RobotAddress& robot, std::shared_ptr<const Dialect> base,
                         bool automatic) {
  AddScheme(base->topics);
  RobotEntry& entry = robots_[robot];
  entry.base = std::move(base);
  entry.automatic = automatic;
}

void RobotDirectory::AddScheme(const TopicScheme& scheme) {
  if (std::find(schemes_.begin(), schemes_.end(), scheme) == schemes_.end()) {
    schemes_.push_back(scheme);
  }
}

// The robot, if its topics have this shape.
RobotEntry* RobotDirectory::Find(const RobotAddress& robot, const TopicScheme& scheme) {
  auto found = robots_.find(robot);
  if (found == robots_.end()) {
    auto admitted = admit_ ? admit_(robot) : std::nullopt;
    if (!admitted || admitted->first->topics != scheme) return nullptr;
    found = robots_.try_emplace(robot).first;
    found->second.base = std::move(admitted->first);
    found->second.automatic = admitted->second;
  }
  return found->second.base->topics == scheme ? &found->second : nullptr;
}

std::optional<TopicLevels> RobotDirectory::Read(const TopicScheme& scheme,
                                                std::string_view topic) const {
  if (scheme.Names("{manufacturer}")) return ReadTopic(scheme, topic);
  for (const auto& [robot, entry] : robots_) {
    if (entry.base->topics != scheme) continue;
    auto levels = ReadTopic(scheme, topic, robot.manufacturer);
    if (levels && levels->robot == robot) return levels;
  }
  return std::nullopt;
}

const RobotEntry* RobotDirectory::Deliver(std::string_view topic, std::string_view payload,
                                          Origin origin) {
  for (const TopicScheme& scheme : schemes_) {
    const auto levels = Read(scheme, topic);
    if (!levels) continue;
    RobotEntry* entry = Find(levels->robot, scheme);
    if (entry == nullptr) continue;
    return Take(*entry, *levels, topic, payload, origin) ? entry : nullptr;
  }
  return nullptr;
}

bool RobotDirectory::Take(RobotEntry& entry, const TopicLevels& levels, std::string_view topic,
                          std::string_view payload, Origin origin) {
  // Asked for again, a broker repeats what it has.
  if (origin == Origin::kRetained && entry.connection && topic == entry.topic) return true;
  if (payload.empty()) return false;
  const bool is_state = levels.topic_name == "state";
  RobotPlace& place = PlaceIn(entry, levels.Place());
  const auto message = ReadMessage(payload);
  if (is_state) {
    TakeState(place, *entry.base, topic, message, origin);
  } else if (!TakeOther(place, *entry.base, topic, message)) {
    return false;
  }
  // A robot that was away when it last was heard lives elsewhere, if anywhere.
  const bool is_live = origin == Origin::kLive;
  const bool leaves = !is_state && place.connection && IsAway(place.connection->connection_state) &&
                      (is_live || !place.speaks);
  place.standing.is_live = (place.standing.is_live || is_live) && !leaves;
  if (leaves) place.speaks = false;
  for (RobotPlace& other : entry.others) {
    RobotPlace& best = entry;
    const bool is_better = !best.IsKnown() || best.standing < other.standing;
    if (other.IsKnown() && is_better) std::swap(best, other);
  }
  return true;
}

// A retained one is the past: it tells that there is a robot and how to speak to it.
void RobotDirectory::TakeState(RobotPlace& place, const Dialect& base, std::string_view topic,
                               const Result<base::JsonDocument>& message, Origin origin) {
  const bool is_live = origin == Origin::kLive;
  place.speaks = place.speaks || is_live;
  if (is_live) place.state_fault = message ? "" : message.error().message;
  if (!place.connection) {
    auto found = DialectFrom(base, topic, message ? ReadConnection(*message) : ConnectionMessage());
    if (found) TakeDialect(place, *std::move(found));
  }
  if (!message || !is_live) return;
  place.state_heard = true;
  place.operating_mode = NormalisedMode(base::StringMember(*message, "operatingMode"));
  TestConditions(place, "state", *message);
}

// Of what cannot be read the topic still tells something.
bool RobotDirectory::TakeOther(RobotPlace& place, const Dialect& base, std::string_view topic,
                               const Result<base::JsonDocument>& message) {
  const std::string fault = message ? "" : message.error().message;
  auto found = DialectFrom(base, topic,
                           message ? ReadConnection(*message) : ConnectionMessage{.fault = fault});
  if (!found) return false;
  const bool is_factsheet = found->topic_name == "factsheet";
  if (is_factsheet) {
    place.factsheet = message ? Share(ReadFactsheet(*message)) : nullptr;
    place.factsheet_fault = fault;
  }
  if (message) TestConditions(place, found->topic_name, *message);
  if (found->topic_name == "connection" || !place.connection) {
    TakeDialect(place, *std::move(found));
  }
  return true;
}

void RobotDirectory::TakeDialect(RobotPlace& place, Discovered found) {
  const bool is_live = place.standing.is_live;
  place.standing = ToStanding(found);
  place.standing.is_live = is_live;
  place.own = found.dialect ? Share(*std::move(found.dialect)) : nullptr;
  place.topic = std::move(found.topic);
  place.said_version = found.message.header.version;
  if (found.topic_name == "connection") place.connection = std::move(found.message);
}

void RobotDirectory::TestConditions(RobotPlace& place, std::string_view topic_name,
                                    const base::JsonValue& message) {
  place.unmet.resize(conditions_.size());
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    if (FindTopicName(conditions_[i]) != topic_name) continue;
    place.unmet[i] = Unmet(conditions_[i], message).value_or("");
  }
}

std::shared_ptr<const Dialect> RobotDirectory::Share(Dialect dialect) {
  return Shared(dialects_, std::move(dialect), std::equal_to<>());
}

std::shared_ptr<const Factsheet> RobotDirectory::Share(Factsheet factsheet) {
  return Shared(factsheets_, std::move(factsheet), [](const Factsheet& a, const Factsheet& b) {
    return a.actions == b.actions && a.limits == b.limits && a.specification == b.specification;
  });
}

}  // namespace fleetpub::vda5050
