// H: the header of every message.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/conformance/case.h"
#include "base/text.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::Shown;
using vda5050::Version;

CaseFinding CheckComplete(Run& run) {
  if (run.heard().empty()) return Inconclusive("nothing came");
  for (const Heard& one : run.heard()) {
    const auto& header = one.header;
    const std::string* const texts[] = {&header.timestamp, &header.version};
    const bool is_whole =
        header.header_id &&
        std::none_of(std::begin(texts), std::end(texts), [](auto* text) { return text->empty(); });
    if (!is_whole) return Fault("a part of the header is missing", {one.Evidence()});
    const auto spoken = vda5050::VersionSpoken(header.version, "");
    if (!spoken || !spoken->is_release || header.version.front() == 'v' ||
        std::count(header.version.begin(), header.version.end(), '.') != 2) {
      return Fault(fmt::format("version is \"{}\"", Shown(header.version)), {one.Evidence()});
    }
  }
  return Pass(base::Counted(run.heard().size(), "message") + ", each with its header");
}

CaseFinding CheckNames(Run& run) {
  if (run.heard().empty()) return Inconclusive("nothing came");
  const vda5050::RobotAddress& robot = run.subject().address;
  std::string other;
  for (const Heard& one : run.heard()) {
    const auto& header = one.header;
    if (header.manufacturer.empty() || header.serial_number.empty()) {
      return Fault("manufacturer or serialNumber is empty", {one.Evidence()});
    }
    if (header.manufacturer != robot.manufacturer || header.serial_number != robot.serial_number) {
      other = fmt::format("; they differ from the topic's, which is allowed: {}/{}",
                          Shown(header.manufacturer), Shown(header.serial_number));
    }
  }
  return Pass("manufacturer and serialNumber are there" + other);
}

bool IsRestart(const Heard& one) { return one.topic_name == "connection" && !one.message.retained; }

// Up by one for each topic. What is missing may be lost, unless other topics had these very ids.
CaseFinding CheckIds(Run& run) {
  struct Topic {
    std::uint32_t last = 0;
    std::size_t count = 0;
  };
  std::map<std::string, Topic> topics;
  std::map<std::uint32_t, std::set<std::string>> users;  // of an id
  for (const Heard& one : run.heard()) {
    if (one.header.header_id) users[*one.header.header_id].insert(one.topic_name);
  }
  const bool may_be_shared = std::all_of(users.begin(), users.end(),
                                         [](const auto& user) { return user.second.size() == 1; });
  std::size_t holes = 0;
  std::size_t steps = 0;
  bool may_restart = false;
  std::string evidence;
  for (const Heard& one : run.heard()) {
    may_restart = may_restart || IsRestart(one);
    if (!one.header.header_id || one.message.retained || one.message.duplicate) continue;
    const std::uint32_t id = *one.header.header_id;
    Topic& topic = topics[one.topic_name];
    if (topic.count++ > 0 && id != topic.last + 1) {
      if (id <= topic.last && !may_restart) {
        return Fault(fmt::format("headerId {} follows {}", id, topic.last), {one.Evidence()});
      }
      bool is_shared = may_be_shared && id > topic.last;
      for (std::uint32_t missing = topic.last + 1; is_shared && missing < id; ++missing) {
        const auto user = users.find(missing);
        is_shared = user != users.end();
      }
      if (is_shared) {
        return Fault(
            fmt::format("the ids between {} and {} were used for other topics", topic.last, id),
            {one.Evidence()});
      }
      ++holes;
      evidence = one.Evidence();
    } else if (topic.count > 1) {
      ++steps;
    }
    topic.last = id;
  }
  if (holes > 0) {
    return Inconclusive(fmt::format("{} gaps: lost on the way, or never used", holes), {evidence});
  }
  if (steps == 0) return Inconclusive("no two messages of a topic came");
  return Pass(fmt::format("{} steps of one", steps));
}

CaseFinding CheckTimes(Run& run) {
  constexpr std::chrono::duration<double> kTolerance{5};
  std::map<std::string, base::WallTime> last;
  std::size_t live = 0;
  for (const Heard& one : run.heard()) {
    const std::string& said = one.header.timestamp;
    const auto time = base::ParseDateTime(said);
    if (!said.ends_with('Z') || !time) {
      return Fault(fmt::format("timestamp is \"{}\", not a time in UTC with Z", Shown(said)),
                   {one.Evidence()});
    }
    if (one.message.retained) continue;
    ++live;
    // A last will is dated when the robot connected.
    if (one.topic_name == "connection") continue;
    const std::chrono::duration<double> off = *time - one.received;
    if (std::abs(off.count()) > kTolerance.count()) {
      return Fault(fmt::format("its clock is {:.0f} s {} ours", std::abs(off.count()),
                               off.count() < 0 ? "behind" : "ahead of"),
                   {one.Evidence()});
    }
    const auto [before, is_first] = last.try_emplace(one.topic_name, *time);
    if (!is_first && *time < before->second) {
      return Fault("the timestamp runs backwards", {one.Evidence()});
    }
    before->second = *time;
  }
  if (live == 0) return Inconclusive("nothing live came");
  return Pass(base::Counted(live, "message"));
}

using enum Version;
constexpr auto kHeaderCases = std::to_array<Case>({
    {"H01", Level::kListen, k110, k300, "7.2 / 6.4",
     "every message has a whole header, its version [Major].[Minor].[Patch]", "",
     "write version as 2.1.0, not v2 or 2.1", CheckComplete},
    {"H02", Level::kListen, k110, k300, "4.2 / 6.4",
     "the header's manufacturer and serialNumber are the robot's", "",
     "fill in both, as in the topic", CheckNames},
    {"H03", Level::kListen, k110, k300, "7.2 / 6.4",
     "headerId goes up by one with each message of a topic", "", "keep a counter for each topic",
     CheckIds},
    {"H04", Level::kListen, k110, k300, "7.2 / 6.4",
     "timestamp is UTC with Z, rises, and is within 5 s of ours", "5 s",
     "synchronise the clock, write 2026-01-02T03:04:05.678Z", CheckTimes},
});

}  // namespace

std::span<const Case> HeaderCases() { return kHeaderCases; }

}  // namespace fleetpub::app::conformance
