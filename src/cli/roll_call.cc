#include "cli/roll_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/text.h"
#include "base/time.h"
#include "vda5050/discovery.h"

namespace fleetpub::cli {
namespace {

using std::chrono::steady_clock;
using vda5050::Condition;
using vda5050::RobotAddress;
using vda5050::RobotFilter;
using vda5050::RobotPattern;
using vda5050::Roster;
using vda5050::RosterEntry;

// More robots than this are asked for by manufacturer: each filter of its own costs a broker more
// than it spares.
constexpr std::size_t kMostFilters = 500;

// What many have left takes its time, and it ends.
constexpr std::chrono::seconds kLongestCollection{60};

bool Needs(const Targets& targets, std::string_view topic_name) {
  return std::any_of(
      targets.where.begin(), targets.where.end(),
      [&](const Condition& condition) { return vda5050::TopicOf(condition) == topic_name; });
}

// In the order in which a broker hands them out: when the connection message is there, so is the
// rest.
std::vector<std::string_view> TopicNames(const Targets& targets, bool factsheets) {
  std::vector<std::string_view> names;
  if (Needs(targets, "state")) names.emplace_back("state");
  if (factsheets || Needs(targets, "factsheet")) names.emplace_back("factsheet");
  names.emplace_back("connection");
  return names;
}

// What to subscribe to.
class Filters {
 public:
  explicit Filters(std::vector<std::string_view> topic_names)
      : topic_names_(std::move(topic_names)) {}

  Status Add(const vda5050::TopicScheme& scheme, const RobotFilter& filter) {
    auto filters = vda5050::DiscoveryFilters(scheme, filter, topic_names_);
    if (!filters) return Fail(std::move(filters.error()));
    for (std::string& one : *filters) {
      if (known_.insert(one).second) filters_.push_back(std::move(one));
    }
    return {};
  }

  std::vector<std::string> Take() { return std::move(filters_); }

 private:
  std::vector<std::string_view> topic_names_;
  std::vector<std::string> filters_;
  std::set<std::string> known_;
};

// Until every robot that is online has sent a state, or nobody may wait any longer.
Status AwaitStates(mqtt::Transport& transport, const Targets& targets, mqtt::Deadline end,
                   Roster& roster, Output& output) {
  std::set<const RosterEntry*> silent;
  for (const auto& [robot, entry] : roster.robots()) {
    if (entry.IsOnline() && !entry.state_heard) silent.insert(&entry);
  }
  if (silent.empty()) return {};
  output.Tell(fmt::format("waiting up to {} for the states of {} robots that are online",
                          base::FormatElapsed(targets.state_wait), silent.size()));
  while (!silent.empty() && steady_clock::now() < end) {
    const auto message = transport.Receive(end);
    if (!message) return Fail(message.error());
    if (!*message) continue;
    const auto origin =
        (*message)->retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
    const RosterEntry* entry = roster.Deliver((*message)->topic, (*message)->payload, origin);
    if (entry != nullptr && (entry->state_heard || !entry->IsOnline())) silent.erase(entry);
  }
  return {};
}

enum class Answer { kYes, kNo, kUnheard, kAway };

Answer Satisfies(const Targets& targets, const RosterEntry& entry) {
  Answer answer = Answer::kYes;
  for (std::size_t i = 0; i < targets.where.size(); ++i) {
    const auto unmet = i < entry.unmet.size() ? entry.unmet[i] : std::nullopt;
    if (unmet && unmet->empty()) continue;
    const bool is_state = vda5050::TopicOf(targets.where[i]) == "state";
    if (unmet || !is_state) return Answer::kNo;
    answer = entry.IsOnline() ? Answer::kUnheard : Answer::kAway;
  }
  return answer;
}

std::string WordsOf(const Targets& targets) {
  std::vector<std::string> words;
  if (!targets.who.set.empty()) words.push_back(base::Printable(targets.who.set));
  for (const Condition& condition : targets.where) {
    words.push_back("--where " + base::Printable(condition.path));
  }
  return base::Join(words, " ");
}

// Why the first one of those that are meant was not chosen.
std::string FirstReason(const Roster& roster) {
  for (const auto& [robot, entry] : roster.robots()) {
    for (const auto& unmet : entry.unmet) {
      if (!unmet || unmet->empty()) continue;
      return fmt::format("; of {}, {}", base::Printable(robot.ToString()), *unmet);
    }
  }
  return "";
}

}  // namespace

Result<Roster> RosterOf(const Targets& targets, const Speaker& speaker) {
  Roster::Admission admit;
  if (!targets.who.patterns.empty()) {
    admit = [&](const RobotAddress& robot)
        -> std::optional<std::pair<std::shared_ptr<const vda5050::Dialect>, bool>> {
      const auto matches = [&](const RobotPattern& pattern) { return pattern.Matches(robot); };
      const auto& patterns = targets.who.patterns;
      if (std::none_of(patterns.begin(), patterns.end(), matches)) return std::nullopt;
      if (targets.IsExcepted(robot)) return std::nullopt;
      auto found = speaker.Found(robot);
      if (!found) return std::nullopt;  // no table is wrong: Schemes() has read them all
      return std::pair(std::move(found->dialect), found->automatic);
    };
  }
  Roster roster(targets.where, std::move(admit));
  if (!targets.who.patterns.empty()) {
    const auto schemes = speaker.Schemes();
    if (!schemes) return Fail(schemes.error());
    for (const vda5050::TopicScheme& scheme : *schemes) roster.AddScheme(scheme);
  }
  for (const RobotAddress& robot : targets.who.robots) {
    auto addressed = targets.where.empty() ? speaker.Named(robot) : speaker.Found(robot);
    if (!addressed) return Fail(std::move(addressed.error()));
    roster.Add(robot, std::move(addressed->dialect), addressed->automatic);
  }
  return roster;
}

Status CallRoll(mqtt::Transport& transport, const Targets& targets, const RollCall& call,
                Roster& roster, Output& output) {
  const bool all = call.check || !targets.where.empty();
  const bool any_automatic =
      std::any_of(roster.robots().begin(), roster.robots().end(),
                  [](const auto& listed) { return listed.second.automatic; });
  Filters filters(TopicNames(targets, call.check || any_automatic));
  const bool each = targets.who.robots.size() <= kMostFilters;
  std::size_t wanted = 0;
  for (const auto& [robot, entry] : roster.robots()) {
    if (!all && !entry.automatic) continue;
    ++wanted;
    RobotFilter filter{.manufacturer = robot.manufacturer, .serial_number = {}};
    if (each) filter.serial_number = robot.serial_number;
    if (auto ok = filters.Add(entry.base->topics, filter); !ok) return ok;
  }
  for (const vda5050::TopicScheme& scheme : roster.schemes()) {
    for (const RobotPattern& pattern : targets.who.patterns) {
      if (auto ok = filters.Add(scheme, pattern.Filter()); !ok) return ok;
    }
  }
  dispatch::CollectOptions discover = call.discover;
  if (!each || !targets.who.patterns.empty()) discover.most = kLongestCollection;
  // A robot may have left messages under another version long ago: only ONLINE ends the search at
  // once.
  const bool may_end = targets.who.patterns.empty() && !Needs(targets, "state");
  const auto start = steady_clock::now();
  auto ok = dispatch::Collect(
      transport, filters.Take(), discover, [&](const mqtt::Message& message) {
        const auto origin = message.retained ? vda5050::Origin::kRetained : vda5050::Origin::kLive;
        roster.Deliver(message.topic, message.payload, origin);
        return may_end && roster.online() >= wanted;
      });
  if (ok && Needs(targets, "state")) {
    ok = AwaitStates(transport, targets, start + targets.state_wait, roster, output);
  }
  return ok;
}

Chosen Choose(const Targets& targets, const Roster& roster, Output& output) {
  Chosen chosen;
  std::vector<RobotAddress> away;
  const auto consider = [&](const ListedRobot& listed) {
    switch (Satisfies(targets, listed.second)) {
      case Answer::kYes:
        return chosen.robots.push_back(&listed);
      case Answer::kUnheard:
        return chosen.unheard.push_back(&listed);
      case Answer::kAway:
        return away.push_back(listed.first);
      case Answer::kNo:
        return;
    }
  };
  std::set<RobotAddress> named;
  for (const RobotAddress& robot : targets.who.robots) {
    const auto found = roster.robots().find(robot);
    if (!targets.who.patterns.empty()) named.insert(robot);
    // One that nothing is known of is for the check to refuse.
    if (found->second.WasHeard()) {
      consider(*found);
    } else {
      chosen.robots.push_back(&*found);
    }
  }
  if (!targets.who.patterns.empty()) {
    for (const ListedRobot& listed : roster.robots()) {
      if (listed.second.connection && !named.contains(listed.first)) consider(listed);
    }
  }
  if (!away.empty()) {
    output.Warn(fmt::format("left out, as they are offline and have left no state: {}",
                            ListOf(away)));
  }
  return chosen;
}

Error NobodyChosen(mqtt::Transport& transport, const Targets& targets, const Speaker& speaker,
                   const Roster& roster, const dispatch::CollectOptions& discover) {
  const auto meant = std::count_if(
      roster.robots().begin(), roster.robots().end(),
      [](const ListedRobot& listed) { return listed.second.connection.has_value(); });
  const std::string nobody = fmt::format("nothing was sent: no robot is {}", WordsOf(targets));
  if (meant > 0) {
    return {ErrorKind::kPreflight,
            fmt::format("{}: {} robot{} heard, none satisfies every --where{}", nobody, meant,
                        meant == 1 ? " was" : "s were", FirstReason(roster))};
  }
  const auto all = AllRobots(transport, speaker.common().topics, discover);
  const std::string heard =
      all.empty() ? "it knows no robot: none has left a connection message"
                  : fmt::format("it knows {} robot{}: {}", all.size(), all.size() == 1 ? "" : "s",
                                ListOf(all));
  return {ErrorKind::kPreflight,
          fmt::format("{} at {}: {}{}", nobody, transport.server().broker.ToString(), heard,
                      targets.except.set.empty() && targets.except.robots.empty()
                          ? ""
                          : "; --except was heeded")};
}

std::vector<RobotAddress> AllRobots(mqtt::Transport& transport, const vda5050::TopicScheme& scheme,
                                    const dispatch::CollectOptions& discover) {
  constexpr std::array<std::string_view, 1> kConnection = {"connection"};
  const auto filters = vda5050::DiscoveryFilters(scheme, {}, kConnection);
  if (!filters) return {};
  std::set<RobotAddress> robots;
  const auto collected =
      dispatch::Collect(transport, *filters, discover, [&](const mqtt::Message& message) {
        const auto levels = vda5050::ReadTopic(scheme, message.topic);
        if (levels && !message.payload.empty()) robots.insert(levels->robot);
        return false;
      });
  if (!collected) return {};
  return {robots.begin(), robots.end()};
}

}  // namespace fleetpub::cli
