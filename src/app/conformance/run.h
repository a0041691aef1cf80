// One robot under test: what it said, and what it is told. Cases (case.h) check by it.
//
// Time and transport are the Wire's, so that tests run in virtual time. What a broker lost shows in
// the header ids of states: a finding that would need what is missing is INCONCLUSIVE.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/verdict.h"
#include "base/json.h"
#include "base/result.h"
#include "base/time.h"
#include "message/command.h"
#include "mqtt/transport.h"
#include "schema/schema.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/messages/order.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app::conformance {

using std::chrono::milliseconds;
using std::chrono::seconds;
using TimePoint = std::chrono::steady_clock::time_point;

/// For whatever is due with the next state; the texts name no time.
inline constexpr seconds kNextState{5};
using vda5050::kLongestSilence;
/// For what is taken back once somebody has stopped the run.
inline constexpr seconds kTakingBack{10};

struct CaseFinding {
  Verdict verdict = Verdict::kInconclusive;
  std::string why;                         ///< printable
  std::vector<std::string> evidence = {};  ///< `state headerId 17`
};

[[nodiscard]] CaseFinding Pass(std::string why, std::vector<std::string> evidence = {});
[[nodiscard]] CaseFinding Fault(std::string why, std::vector<std::string> evidence = {});
[[nodiscard]] CaseFinding Skipped(std::string why);
[[nodiscard]] CaseFinding Inconclusive(std::string why, std::vector<std::string> evidence = {});

/// The first violation, `/path: what`, that is none of the header, which has its own cases; "": none.
[[nodiscard]] std::string DescribeViolation(std::span<const message::Violation> violations);

/// A message of the robot's.
struct Heard {
  TimePoint at;
  base::WallTime received;
  std::string topic_name;  ///< `state`
  mqtt::Message message;
  base::JsonDocument json;  ///< null when it is no object
  vda5050::MessageHeader header;
  std::optional<vda5050::RobotState> state;

  [[nodiscard]] std::string Evidence() const;
};
[[nodiscard]] Heard MakeHeard(std::string topic_name, mqtt::Message message, TimePoint at,
                              base::WallTime received);
/// The broker may drop states: the next id then lies further ahead. One that falls is another fault.
[[nodiscard]] bool IsHole(const Heard& before, const Heard& after);

/// The robot's broker and its clock.
class Wire {
 public:
  Wire() = default;
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  virtual ~Wire() = default;

  /// Stamps, records and publishes.
  [[nodiscard]] virtual Status Send(const message::Command& command) = 0;
  /// The next message, by the last level of its topic; nothing at the deadline.
  [[nodiscard]] virtual std::optional<std::pair<std::string, mqtt::Message>> Next(
      TimePoint until) = 0;
  [[nodiscard]] virtual TimePoint Now() const = 0;
  [[nodiscard]] virtual base::WallTime WallNow() const = 0;
  [[nodiscard]] virtual bool IsStopped() const { return false; }
};

/// Where it may drive.
struct Way {
  /// Nodes and edges there; empty: straight on from where it stands, `distance` m.
  vda5050::OrderPath there = {};
  vda5050::OrderPath back = {};
  double distance = 2;
};

struct Subject {
  vda5050::RobotAddress address;
  vda5050::Dialect dialect;
  std::optional<vda5050::Factsheet> factsheet;
  Way way = {};
};

/// What was waited for.
struct Awaited {
  const Heard* found = nullptr;
  bool is_late = false;         ///< it came, but after the limit
  const Heard* last = nullptr;  ///< not found: the state that closes the case; null: none came
  bool has_hole = false;        ///< states are missing

  /// Nothing is missing, and it did not come.
  [[nodiscard]] bool IsRefuted() const { return found == nullptr && last != nullptr && !has_hole; }
};

using StateTest = std::function<bool(const vda5050::RobotState& state)>;
/// Whether it shows the action of this id as ended, FINISHED or FAILED.
[[nodiscard]] StateTest ShowsEnd(const std::string& id);

class Run {
 public:
  /// All outlive it.
  Run(Subject subject, Wire& wire, schema::Registry& registry);

  [[nodiscard]] const Subject& subject() const { return subject_; }
  [[nodiscard]] vda5050::Version version() const { return subject_.dialect.version; }
  [[nodiscard]] bool Is30() const { return version() >= vda5050::Version::k300; }
  [[nodiscard]] schema::Registry& registry() const { return registry_; }

  // ---- What was heard ----

  [[nodiscard]] const std::deque<Heard>& heard() const { return heard_; }
  [[nodiscard]] TimePoint began() const { return began_; }
  [[nodiscard]] TimePoint Now() const { return wire_.Now(); }
  [[nodiscard]] std::vector<const Heard*> Of(std::string_view topic_name) const;
  /// Live states from this place in heard() on.
  [[nodiscard]] std::vector<const Heard*> StatesSince(std::size_t mark) const;
  [[nodiscard]] std::size_t mark() const { return heard_.size(); }
  /// The last live one; null: none came.
  [[nodiscard]] const Heard* last_state() const { return last_state_; }
  /// Whether a state is missing among those since.
  [[nodiscard]] bool HasHole(std::size_t mark) const;

  void Listen(std::chrono::nanoseconds time);
  /// Until a live state passes the test; that of now does not count. One that does not come by the limit is
  /// waited for until the next state closes the case.
  Awaited Await(const StateTest& test, std::chrono::nanoseconds limit = kNextState);
  /// The same, of all that came since.
  Awaited AwaitSince(std::size_t mark, TimePoint from, const StateTest& test,
                     std::chrono::nanoseconds limit);
  /// Has the robot send its state, and waits until that has ended.
  void Refresh();
  /// The same, until all instant actions of ours have ended.
  Awaited AwaitOwnActions();
  /// A finding on what did not come: FAIL when that is certain.
  [[nodiscard]] static CaseFinding Missing(const Awaited& awaited, std::string what);

  // ---- What is said ----

  /// Sends one; returns its id. The error is noted as the reason to end.
  std::string Do(std::string_view type, std::vector<vda5050::Parameter> parameters = {},
                 std::string id = {});
  /// Sends an order, without header. One that is meant to be valid and is not ends the run.
  enum class Intent : std::uint8_t { kValid, kWrong };
  void SendOrder(const base::JsonDocument& order, Intent intent = Intent::kValid);
  /// Something that is no JSON, to `instantActions`.
  void SendGarbage();
  /// Whether this id is of an instant action of ours.
  [[nodiscard]] bool IsInstant(const std::string& id) const { return instant_ids_.contains(id); }

  [[nodiscard]] std::string MakeId(std::string_view what);
  /// Whether its factsheet lists the action for this scope; without a list nobody knows.
  [[nodiscard]] std::optional<bool> Knows(std::string_view type, std::string_view scope) const;

  // ---- The whole ----

  /// Why nothing may be sent any more; "": nothing is against it.
  [[nodiscard]] const std::string& abort_reason() const { return abort_; }
  void Abort(std::string why);
  /// Whether somebody ended it: nothing leaves any more.
  [[nodiscard]] bool is_stopped() const { return stopped_at_.has_value(); }
  /// Takes back what was done; also when it is stopped, for kTakingBack.
  template <class Use>
  void TakeBack(Use use) {
    takes_back_ = true;
    use();
    takes_back_ = false;
  }
  /// What several cases need once: `what` is made by `make` at its first use.
  template <class T, class Make>
  T& Once(std::string_view what, Make make) {
    auto& slot = once_[std::string(what)];
    if (slot == nullptr) slot = std::make_shared<T>(make());
    return *std::static_pointer_cast<T>(slot);
  }

 private:
  void Take(std::string topic_name, mqtt::Message message);
  bool IsOver();
  bool Step(TimePoint until);
  void CheckState(const vda5050::RobotState& state);
  void Send(Result<message::Command> command, Intent intent);

  Subject subject_;
  Wire& wire_;
  schema::Registry& registry_;
  TimePoint began_;
  std::deque<Heard> heard_;
  const Heard* last_state_ = nullptr;
  std::string mode_;  // at first
  std::string abort_;
  std::optional<TimePoint> stopped_at_;
  bool takes_back_ = false;
  std::set<std::string> instant_ids_;
  std::uint32_t made_ids_ = 0;
  std::map<std::string, std::shared_ptr<void>> once_;
};

}  // namespace fleetpub::app::conformance
