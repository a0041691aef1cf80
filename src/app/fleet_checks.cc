// The checks of a fleet. Another one: a function, and its row in kFleetChecks.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "app/doctor.h"
#include "base/text.h"
#include "base/time.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {
namespace {

using base::Counted;
using base::FormatElapsed;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using vda5050::RobotAddress;
using vda5050::Shown;

constexpr seconds kClockSlack{5};
constexpr seconds kClockLimit{60};

// Tells what one check finds of one robot.
class Finder {
 public:
  Finder(Diagnosis blank, const ListeningFacts& listening, const DiagnosisHook& tell)
      : blank_(std::move(blank)), listening_(listening), tell_(tell) {}

  void Problem(std::string text, Remedy remedy) {
    Tell(Health::kProblem, std::move(text), std::move(remedy));
  }
  void Warn(std::string text, Remedy remedy) {
    Tell(Health::kWarning, std::move(text), std::move(remedy));
  }
  void Tell(Health health, std::string text, Remedy remedy) {
    told_ = true;
    tell_({blank_.check, health, blank_.subject, std::move(text), std::move(remedy), blank_.kind});
  }
  /// There was something to look at.
  void Examined() { was_examined_ = true; }

  [[nodiscard]] bool Hears(std::string_view topic_name) const {
    return !listening_.refused.contains(topic_name);
  }
  [[nodiscard]] const ListeningFacts& listening() const { return listening_; }
  [[nodiscard]] bool has_told() const { return told_; }
  [[nodiscard]] bool is_right() const { return was_examined_ && !told_; }

  /// `fleetpub COMMAND ROBOT OPTIONS…`
  [[nodiscard]] Remedy Try(std::string command, std::vector<std::string> options = {}) const {
    Remedy remedy{.command = {"fleetpub", std::move(command), blank_.subject}};
    for (std::string& option : options) remedy.command.push_back(std::move(option));
    return remedy;
  }
  [[nodiscard]] Remedy LookAt() const { return Try("validate", {"--live", "--for", "35s"}); }
  /// Deletes what the broker has retained there.
  [[nodiscard]] Remedy Clear(const std::string& topic) const {
    const auto& broker = listening_.broker;
    if (!broker || broker->UsesTls() || broker->UsesWebSocket()) {
      return {.advice = "publish an empty retained message there: mosquitto_pub -r -n"};
    }
    return {.command = {"mosquitto_pub", "-h", broker->host, "-p", std::to_string(broker->port),
                        "-r", "-n", "-t", topic}};
  }

 private:
  Diagnosis blank_;
  const ListeningFacts& listening_;
  const DiagnosisHook& tell_;
  bool told_ = false;
  bool was_examined_ = false;
};

void CheckRetained(const PlaceEvidence& place, Finder& finder) {
  const auto is_retained = [&](std::string_view topic_name) {
    const TopicEvidence* const topic = place.Find(std::string(topic_name));
    return topic != nullptr && topic->is_retained ? topic : nullptr;
  };
  if (finder.Hears("order") && finder.Hears("instantActions")) finder.Examined();
  for (const std::string_view command : vda5050::kCommandTopics) {
    if (const TopicEvidence* const topic = is_retained(command)) {
      finder.Problem(Shown(topic->topic) + " is retained: the robot gets it again at each connect",
                     finder.Clear(topic->topic));
    }
  }
  for (const char* const report : {"state", "visualization"}) {
    if (const TopicEvidence* const topic = is_retained(report)) {
      finder.Warn(Shown(topic->topic) + " is retained: who connects takes the past for the present",
                  finder.Clear(topic->topic));
    }
  }
}

void CheckConnection(const PlaceEvidence& place, Finder& finder) {
  if (!finder.listening().knows_retained || !finder.Hears("connection")) return;
  const TopicEvidence* const topic = place.Find("connection");
  if (topic != nullptr && topic->is_retained) return finder.Examined();
  if (topic == nullptr && !place.SendsStates()) return;
  finder.Problem("no connection message is retained: who connects later cannot see the robot",
                 {.advice = "the robot must publish its connection with the retain flag"});
}

void CheckOnline(const PlaceEvidence& place, Finder& finder) {
  if (!finder.Hears("state") || !place.connection) return;
  const std::string topic = Shown(place.Find("connection")->topic);
  const nanoseconds silence = finder.listening().elapsed - place.since;
  if (place.SendsStates()) {
    finder.Examined();
    if (!vda5050::IsAway(place.connection->connection_state)) return;
    finder.Warn(fmt::format("sends states, but {} says {}", topic,
                            vda5050::ConnectionText(*place.connection)),
                {.advice = "the robot must publish ONLINE whenever it connects: restart it"});
  } else if (!place.IsOnline()) {
    finder.Examined();
  } else if (silence >= vda5050::kLongestSilence) {
    finder.Problem(fmt::format("{} says ONLINE, but no state came in {}: it may be long gone",
                               topic, FormatElapsed(silence)),
                   finder.Try("stateRequest", {"--wait"}));
  } else {
    finder.Tell(Health::kUnknown, "no state came in " + FormatElapsed(silence),
                finder.Try("doctor", {"--for", "35s"}));
  }
}

void CheckIntervals(const PlaceEvidence& place, Finder& finder) {
  if (!place.SendsStates()) return;
  const Rhythm& rhythm = place.Find("state")->rhythm;
  const bool has_left = place.connection && vda5050::IsAway(place.connection->connection_state);
  const nanoseconds silence =
      has_left ? rhythm.longest : rhythm.FindSilence(finder.listening().elapsed, place.since);
  std::optional<nanoseconds> usual;
  if (place.factsheet) usual = place.factsheet->usual_interval;
  const Remedy look = finder.Try("tail", {"--topic", "state"});
  finder.Examined();
  if (silence > vda5050::kLongestSilence) {
    finder.Problem(
        fmt::format("{} without a state, which is due every 30 s", FormatElapsed(silence)), look);
  } else if (usual && silence > *usual * 2 + seconds(1)) {
    finder.Warn(fmt::format("{} without a state: its factsheet says every {}",
                            FormatElapsed(silence), FormatElapsed(*usual)),
                look);
  }
}

// What is wrong with a member of headers: mostly the same on each topic.
void TellHeaderFaults(const PlaceEvidence& place, std::string_view member, Health health,
                      Finder& finder) {
  std::vector<std::string> topics;
  std::string text;
  for (const auto& [topic_name, topic] : place.topics) {
    if (!topic.versions.empty()) finder.Examined();
    const auto fault = topic.header_faults.find(member);
    if (fault == topic.header_faults.end()) continue;
    topics.push_back(topic_name);
    text = fault->second;
  }
  if (topics.empty()) return;
  finder.Tell(health, fmt::format("{}: {} {}", base::Join(topics, ", "), member.substr(1), text),
              finder.LookAt());
}

void CheckClock(const PlaceEvidence& place, Finder& finder) {
  TellHeaderFaults(place, "/timestamp", Health::kWarning, finder);
  for (const auto& [topic_name, topic] : place.topics) {
    const Clock& clock = topic.clock;
    if (!clock.offset) continue;
    finder.Examined();
    const nanoseconds off = std::chrono::abs(*clock.offset);
    if (off > kClockSlack) {
      finder.Tell(
          off > kClockLimit ? Health::kProblem : Health::kWarning,
          fmt::format("{}: timestamps are {} {} our clock", topic_name, FormatElapsed(off),
                      clock.offset->count() < 0 ? "behind" : "ahead of"),
          {.advice = "set the clock of who publishes this, or of this host when all differ (NTP)"});
    } else if (clock.backwards > 0) {
      finder.Warn(fmt::format("{}: {} older than the message before", topic_name,
                              Counted(clock.backwards, "timestamp")),
                  {.advice = "its clock was set back, or two publish there"});
    }
  }
}

void CheckHeaderIds(const PlaceEvidence& place, Finder& finder) {
  for (const auto& [topic_name, topic] : place.topics) {
    const HeaderIds& ids = topic.ids;
    if (ids.messages > 1) finder.Examined();
    if (ids.missing > 0) {
      finder.Problem(
          fmt::format("{}: {} without headerId", topic_name, Counted(ids.missing, "message")),
          finder.LookAt());
    } else if (ids.repeated > 0 && ids.repeated + 1 == ids.messages) {
      finder.Problem(fmt::format("{}: headerId is always {}", topic_name, *ids.last),
                     finder.LookAt());
    } else if (ids.resumed > 0 || ids.repeated > 0) {
      finder.Problem(
          fmt::format("{}: two publishers count headerId here: {} came twice, the count "
                      "went back and forth {}",
                      topic_name, Counted(ids.repeated, "id"), Counted(ids.resumed, "time")),
          {.advice = "find the other one: the broker's log names the clients"});
    } else if (ids.falls > 0) {
      finder.Warn(
          fmt::format("{}: headerId began anew {}", topic_name, Counted(ids.falls, "time")),
          {.advice = "a robot that restarts may do so; a running one is broken, or two publish"});
    } else if (ids.skipped > 0) {
      finder.Warn(fmt::format("{}: {} missing between {}", topic_name, Counted(ids.skipped, "id"),
                              Counted(ids.messages, "message")),
                  {.advice = "messages are lost on their way, or other topics share the count"});
    }
  }
}

void CheckVersion(const PlaceEvidence& place, Finder& finder) {
  TellHeaderFaults(place, "/version", Health::kProblem, finder);
  std::set<std::string> said;
  for (const auto& [topic_name, topic] : place.topics) {
    said.insert(topic.versions.begin(), topic.versions.end());
  }
  if (said.size() < 2) return;
  const std::vector<std::string> versions(said.begin(), said.end());
  finder.Problem(fmt::format("its messages speak {} at once", base::Join(versions, " and ")),
                 {.advice = "an old one is still retained, or two robots bear one name"});
}

void CheckNames(const PlaceEvidence& place, Finder& finder) {
  TellHeaderFaults(place, "/manufacturer", Health::kProblem, finder);
  TellHeaderFaults(place, "/serialNumber", Health::kProblem, finder);
}

// 1.1 has none.
bool HasFactsheets(const PlaceEvidence& place) {
  const std::string none(vda5050::GetFacts(vda5050::Version::k110).name);
  return std::none_of(place.topics.begin(), place.topics.end(),
                      [&](const auto& topic) { return topic.second.versions.contains(none); });
}

void CheckFactsheet(const PlaceEvidence& place, Finder& finder) {
  if (!finder.Hears("factsheet") || !HasFactsheets(place)) return;
  const bool knows_retained = finder.listening().knows_retained;
  const Remedy ask = finder.Try("factsheetRequest", {"--wait"});
  if (!place.factsheet) {
    if (!knows_retained || !place.IsThere()) return;
    return finder.Problem("has no factsheet: what it can do is not known", ask);
  }
  finder.Examined();
  if (!place.factsheet->fault.empty()) {
    finder.Problem("its factsheet cannot be read: " + Shown(place.factsheet->fault), ask);
  } else if (!place.Find("factsheet")->is_retained && knows_retained) {
    finder.Problem("its factsheet is not retained: who connects later does not get it", ask);
  } else if (place.factsheet->actions == 0) {
    finder.Warn("its factsheet lists no actions: commands leave without a check that it can",
                {.advice = "the robot's maker completes it"});
  }
}

void CheckActionLists(const PlaceEvidence& place, Finder& finder) {
  if (place.SendsStates()) finder.Examined();
  for (const std::string& error : place.full_lists) {
    finder.Problem(Shown(error, 80) + ": it takes no further instant actions",
                   finder.Try("clearInstantActions", {"--wait"}));
  }
}

void CheckMessages(const PlaceEvidence& place, Finder& finder) {
  for (const auto& [topic_name, topic] : place.topics) {
    if (!topic.versions.empty()) finder.Examined();
    if (topic.invalid == 0) continue;
    finder.Problem(fmt::format("{}: {} not as the schema says: {}", topic_name,
                               Counted(topic.invalid, "message"), Shown(topic.violation)),
                   finder.LookAt());
  }
}

struct FleetCheck {
  std::string_view id;
  ErrorKind kind;          ///< of a problem
  std::string_view right;  ///< what is so when nothing is wrong
  void (*examine)(const PlaceEvidence& place, Finder& finder);
};

constexpr auto kFleetChecks = std::to_array<FleetCheck>({
    {"retained", ErrorKind::kInvalid, "no order, action or state is retained", CheckRetained},
    {"connection", ErrorKind::kInvalid, "the connection message is retained", CheckConnection},
    {"online", ErrorKind::kUnconfirmed, "who says ONLINE sends states", CheckOnline},
    {"intervals", ErrorKind::kInvalid, "states come in time", CheckIntervals},
    {"clock", ErrorKind::kInvalid, "timestamps agree with our clock", CheckClock},
    {"header-ids", ErrorKind::kInvalid, "header ids count up by one", CheckHeaderIds},
    {"version", ErrorKind::kInvalid, "topics and headers tell one version", CheckVersion},
    {"names", ErrorKind::kInvalid, "headers name the robot of their topic", CheckNames},
    {"factsheet", ErrorKind::kPreflight, "the factsheet is there", CheckFactsheet},
    {"action-lists", ErrorKind::kPreflight, "instant actions have room", CheckActionLists},
    {"messages", ErrorKind::kInvalid, "messages are as their schemas say", CheckMessages},
});

void Run(const FleetCheck& check, const FleetEvidence& evidence, const ListeningFacts& listening,
         const DiagnosisHook& tell) {
  std::size_t right = 0;
  bool has_told = false;
  for (const auto& [address, robot] : evidence.robots()) {
    Finder finder({.check = check.id, .subject = address.ToString(), .kind = check.kind}, listening,
                  tell);
    for (const auto& [name, place] : robot) check.examine(place, finder);
    if (finder.is_right()) ++right;
    has_told = has_told || finder.has_told();
  }
  if (right > 0) {
    tell({check.id, Health::kOk, Counted(right, "robot"), std::string(check.right)});
  } else if (!has_told) {
    tell({check.id, Health::kUnknown, Counted(evidence.robots().size(), "robot"),
          "nothing was heard to judge this by"});
  }
}

// Of one name at several places (`uagv/v2`, `vda5050/v3`).
void CheckPlaces(const FleetEvidence& evidence, const DiagnosisHook& tell) {
  std::size_t right = 0;
  for (const auto& [address, robot] : evidence.robots()) {
    std::vector<std::string> heard;
    std::size_t there = 0;
    for (const auto& [name, place] : robot) {
      heard.push_back(Shown(name, 80));
      if (place.IsThere()) ++there;
    }
    if (heard.size() < 2) {
      ++right;
      continue;
    }
    const std::string name = address.ToString();
    tell({"places",
          there > 1 ? Health::kProblem : Health::kWarning,
          name,
          fmt::format("has topics below {}{}", base::Join(heard, " and "),
                      there > 1 ? ", and is at several now: two robots may bear one name" : ""),
          {.command = {"fleetpub", "tail", name}}});
  }
  if (right > 0) tell({"places", Health::kOk, Counted(right, "robot"), "topics lie at one place"});
}

void CheckPresence(const FleetEvidence& evidence, const ListeningFacts& listening,
                   const DiagnosisHook& tell) {
  const auto& named = listening.named;
  const std::size_t heard = evidence.robots().size();
  bool are_all = true;
  const auto miss = [&](std::string subject, Health health, const char* text, Remedy remedy) {
    are_all = false;
    tell({"presence", health, std::move(subject), text, std::move(remedy), ErrorKind::kPreflight});
  };
  const Remedy look{.command = {"fleetpub", "fleet"}};
  for (const RobotAddress& robot : named) {
    if (evidence.robots().contains(robot)) continue;
    miss(robot.ToString(), Health::kProblem, "nothing was heard of it, and nothing is retained",
         look);
  }
  for (const auto& [robot, scheme, was_commanded] : listening.expected) {
    if (evidence.robots().contains(robot)) continue;
    if (std::find(named.begin(), named.end(), robot) != named.end()) continue;
    miss(robot.ToString(), was_commanded ? Health::kWarning : Health::kUnknown,
         was_commanded ? "was commanded within a week, and nothing was heard of it"
                       : "is configured, and nothing was heard of it here",
         look);
  }
  if (heard == 0 && named.empty()) {
    const Remedy listen{.command = {"fleetpub", "tail", "--filter", "#"}};
    miss("0 robots", Health::kProblem,
         "none was heard: another broker, other topics, or a login that may not read them",
         listening.broker ? listen : Remedy());
  }
  if (are_all) tell({"presence", Health::kOk, Counted(heard, "robot"), "all expected were heard"});
}

}  // namespace

void ExamineFleet(const FleetEvidence& evidence, const ListeningFacts& listening,
                  const DiagnosisHook& tell) {
  CheckPresence(evidence, listening, tell);
  if (evidence.robots().empty()) return;
  for (const FleetCheck& check : kFleetChecks) Run(check, evidence, listening, tell);
  CheckPlaces(evidence, tell);
}

}  // namespace fleetpub::app
