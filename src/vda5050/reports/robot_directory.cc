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

// Of two at which a robot speaks alike, it stays at the one where it did so first: nothing is mixed.
bool IsBetter(const RobotPlace& other, const RobotPlace& best) {
  if (!other.IsKnown()) return false;
  const bool both_speak = other.standing.is_live && best.standing.is_live;
  if (both_speak && other.standing.rank == best.standing.rank) return false;
  return !best.IsKnown() || best.standing < other.standing;
}

bool TellsOfARobot(std::string_view topic_name) {
  return topic_name == "connection" || topic_name == "state" || topic_name == "factsheet";
}

void ChooseBest(RobotEntry& entry) {
  RobotPlace& best = entry;
  for (RobotPlace& other : entry.others) {
    if (IsBetter(other, best)) std::swap(best, other);
  }
}

void NoteTime(RobotPlace& place, const MessageHeader& header) {
  const auto time = ReadTime(header);
  if (time && (!place.last_said || *place.last_said < *time)) place.last_said = time;
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

std::string_view RobotEntry::InterfaceName() const {
  const std::string_view levels = place;
  return levels.substr(0, levels.rfind('/'));
}

std::string_view RobotEntry::TopicLevel() const {
  const std::string_view levels = place;
  return levels.substr(std::min(levels.size(), levels.rfind('/') + 1));
}

std::string_view RobotEntry::AlsoAt() const {
  const auto other = std::find_if(others.begin(), others.end(), [](const RobotPlace& one) {
    return one.speaks || (one.connection && one.connection->connection_state == "ONLINE");
  });
  return other == others.end() ? std::string_view() : std::string_view(other->place);
}

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
ListedRobot* RobotDirectory::Find(const RobotAddress& robot, const TopicScheme& scheme) {
  auto found = robots_.find(robot);
  if (found == robots_.end()) {
    auto admitted = admit_ ? admit_(robot) : std::nullopt;
    if (!admitted || admitted->first->topics != scheme) return nullptr;
    found = robots_.try_emplace(robot).first;
    found->second.base = std::move(admitted->first);
    found->second.automatic = admitted->second;
  }
  return found->second.base->topics == scheme ? &*found : nullptr;
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

std::size_t RobotDirectory::CountSeen() const {
  return static_cast<std::size_t>(
      std::count_if(robots_.begin(), robots_.end(),
                    [](const ListedRobot& listed) { return listed.second.WasSeen(); }));
}

const ListedRobot* RobotDirectory::Deliver(std::string_view topic, std::string_view payload,
                                           Origin origin) {
  for (const TopicScheme& scheme : schemes_) {
    const auto levels = Read(scheme, topic);
    if (!levels || !TellsOfARobot(levels->topic_name)) continue;
    ListedRobot* listed = Find(levels->robot, scheme);
    if (listed == nullptr) continue;
    return Take(listed->second, *levels, topic, payload, origin) ? listed : nullptr;
  }
  return nullptr;
}

bool RobotDirectory::Take(RobotEntry& entry, const TopicLevels& levels, std::string_view topic,
                          std::string_view payload, Origin origin) {
  const bool is_state = levels.topic_name == "state";
  if (payload.empty()) return levels.topic_name == "connection" && TakeBack(entry, levels);
  RobotPlace& place = PlaceIn(entry, levels.Place());
  const auto message = ReadMessage(payload);
  if (is_state) {
    if (!TakeState(place, *entry.base, topic, message, origin)) return false;
  } else if (!TakeOther(place, *entry.base, topic, message)) {
    return false;
  }
  // A robot that was away when it last was heard lives elsewhere, if anywhere.
  const bool is_live = origin == Origin::kLive;
  const bool leaves = !is_state && place.connection && IsAway(place.connection->connection_state) &&
                      (is_live || !place.speaks);
  place.standing.is_live = (place.standing.is_live || is_live) && !leaves;
  if (leaves) place.speaks = false;
  place.has_begun_anew = place.has_begun_anew || (is_live && levels.topic_name == "connection");
  ChooseBest(entry);
  return true;
}

// A retained connection message was deleted.
bool RobotDirectory::TakeBack(RobotEntry& entry, const TopicLevels& levels) {
  RobotPlace& place = PlaceIn(entry, levels.Place());
  if (!place.connection) return false;
  place.connection.reset();
  place.standing.rank = 0;
  ChooseBest(entry);
  return true;
}

// A retained one is the past: it tells that there is a robot and how to speak to it.
bool RobotDirectory::TakeState(RobotPlace& place, const Dialect& base, std::string_view topic,
                               const Result<base::JsonDocument>& message, Origin origin) {
  const bool is_live = origin == Origin::kLive;
  std::optional<RobotState> state;
  if (message && is_live && states_) {
    state = ReadState(*message);
    const bool is_late = place.state && !std::exchange(place.has_begun_anew, false) &&
                         IsBefore(state->header, place.state->header);
    if (is_late) return false;
  }
  place.speaks = place.speaks || is_live;
  if (is_live) place.state_fault = message ? "" : message.error().message;
  if (!place.connection) {
    ConnectionMessage read = message ? ReadConnection(*message) : ConnectionMessage();
    CutHeaderTexts(read);
    auto found = DialectFrom(base, topic, std::move(read));
    if (found) TakeDialect(place, *std::move(found));
  }
  if (message) NoteTime(place, ReadHeader(*message));
  if (!message || !is_live) return true;
  place.state_heard = true;
  place.operating_mode = NormalisedMode(base::StringMember(*message, "operatingMode"));
  TestConditions(place, "state", *message);
  if (state) states_->Keep(place.state, *std::move(state));
  return true;
}

// Of what cannot be read the topic still tells something.
bool RobotDirectory::TakeOther(RobotPlace& place, const Dialect& base, std::string_view topic,
                               const Result<base::JsonDocument>& message) {
  const std::string fault = message ? "" : message.error().message;
  ConnectionMessage read = message ? ReadConnection(*message) : ConnectionMessage{.fault = fault};
  CutHeaderTexts(read);
  auto found = DialectFrom(base, topic, std::move(read));
  if (!found) return false;
  NoteTime(place, found->message.header);
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
    return a.actions == b.actions && a.limits == b.limits &&
           a.optional_parameters == b.optional_parameters &&
           a.has_optional_parameters == b.has_optional_parameters &&
           a.specification == b.specification;
  });
}

int WeighTrouble(const RobotEntry& entry) {
  constexpr int kUnreadable = 6;
  constexpr int kBroken = 5;
  int weight = 0;
  const auto add = [&](bool applies, int so_much) {
    if (applies) weight = std::max(weight, so_much);
  };
  const std::string_view said =
      entry.connection ? std::string_view(entry.connection->connection_state) : "";
  add(said == "CONNECTION_BROKEN" && !entry.IsAlive(), kBroken);
  add(entry.connection && !entry.connection->fault.empty(), kUnreadable);
  add(!entry.state_fault.empty(), kUnreadable);
  if (!entry.state) return weight;
  const LiveState& state = *entry.state;
  add(IsEmergencyStopped(state), 8);
  add(state.field_violation == true, 6);
  add(state.paused == true, 1);
  add(!state.operating_mode.empty() && state.operating_mode != "AUTOMATIC", 1);
  for (const RobotError& error : state.errors) {
    constexpr int kByLevel[] = {3, 2, 4, 5, 7};  // another, WARNING, URGENT, CRITICAL, FATAL
    add(true, kByLevel[WeighLevel(error.level) + 1]);
  }
  return weight;
}

bool HasProblem(const RobotEntry& entry) { return WeighTrouble(entry) >= 3; }

}  // namespace fleetpub::vda5050
