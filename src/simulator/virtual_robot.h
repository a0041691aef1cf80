// One virtual robot: a state machine that is fed with messages and with time, and answers with
// messages. It touches no network and no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "base/time.h"
#include "mqtt/transport.h"
#include "simulator/action_handlers.h"
#include "simulator/inspection.h"
#include "simulator/messages.h"
#include "simulator/order_run.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"
#include "simulator/settings.h"

namespace fleetpub::simulator {

/// The time, twice: for waiting and for timestamps.
struct Moment {
  std::chrono::steady_clock::time_point steady;
  base::WallTime wall;
};
[[nodiscard]] inline Moment Now() {
  return {std::chrono::steady_clock::now(), base::WallTime::clock::now()};
}

/// How often a running simulation asks whether it is to stop.
constexpr std::chrono::milliseconds kStopPollInterval{50};

/// What a robot says.
struct Utterance {
  std::string_view topic;  ///< the last level: `connection`, `state`, `factsheet`
  std::string payload;
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;
  bool retained = false;
};

using Utterances = std::vector<Utterance>;

/// What somebody who watches wants to know.
struct Event {
  enum class Kind {
    kReceived,  ///< a command came
    kFault,     ///< what was received breaks the specification
  };
  Kind kind = Kind::kReceived;
  std::string text;
};

class VirtualRobot {
 public:
  using EventCallback = std::function<void(const Event&)>;

  /// What robots of one fleet share; all of it outlives them.
  struct Shared {
    const Settings& settings;
    const ProtocolTerms& terms;
    Inspector& inspector;
    const std::string& factsheet;  ///< FactsheetBody; "": the version has none
  };

  VirtualRobot(const Shared& shared, Header header);

  /// The last will, to be handed to the broker before Start.
  [[nodiscard]] Utterance Will(const Moment& now);
  /// Connected, or connected again: ONLINE, the factsheet, a state.
  void Start(const Moment& now, Utterances& out);
  /// A message of `instantActions`, `order`, `zoneSet` or `responses`.
  void Receive(std::string_view topic, std::string_view payload, const Moment& now, Utterances& out,
               const EventCallback& on_event);
  /// To be called at Due() or later.
  void Tick(const Moment& now, Utterances& out);
  /// The orderly end: OFFLINE.
  void End(const Moment& now, Utterances& out);

  /// When Tick has something to do.
  [[nodiscard]] std::chrono::steady_clock::time_point Due() const;
  /// Has shut down: says nothing and hears nothing any more.
  [[nodiscard]] bool gone() const { return gone_; }
  [[nodiscard]] const RobotState& state() const { return state_; }

 private:
  struct Running {
    ActionCall call;
    std::chrono::steady_clock::time_point next;  // of the next change of its status
    bool retried = false;
  };

  void ReceiveActions(std::string_view payload, const Moment& now, const EventCallback& on_event);
  void ReceiveOrder(std::string_view payload, const Moment& now, const EventCallback& on_event);
  void ReceiveZoneSet(std::string_view payload, const EventCallback& on_event);
  void ReceiveResponses(std::string_view payload, const Moment& now, const EventCallback& on_event);
  [[nodiscard]] Inspection InspectFor(std::string_view topic, std::string_view payload,
                                      std::string_view error_type, const EventCallback& on_event);
  void ApplyMode(std::string_view mode);
  void NoteLeases(const Moment& now);
  void CatchUp(const Moment& now, bool is_heard);
  void Proceed(const Moment& now);
  void Cancel(const ActionCall& call, const Moment& now);
  [[nodiscard]] bool IsCancelling() const;
  [[nodiscard]] bool FinishCancels();
  [[nodiscard]] ActionResult CarryOut(const ActionCall& call);
  void RefuseMessage(const Inspection& inspection, std::string_view topic);
  void Begin(const ReceivedAction& action, const Moment& now);
  [[nodiscard]] std::string ReasonToReject(const ReceivedAction& action) const;
  void Reject(const ReceivedAction& action, const std::string& reason);
  void Advance(Running& running, const Moment& now);
  void Complete(const Running& running, const Moment& now);
  void ApplySideEffect(const ActionResult& result, const Moment& now);
  void Retry(const std::string& id, const Moment& now);
  void AddError(RobotError error);
  void ForgetOldActions();
  [[nodiscard]] bool IsListFull() const;
  void TellWhetherListIsFull();
  [[nodiscard]] ActionState* Find(std::string_view id);
  void Remember(const std::string& id);

  [[nodiscard]] bool Has(Fault fault) const { return shared_.settings.Has(fault); }
  [[nodiscard]] std::string Compose(std::string_view body, std::uint32_t& counter,
                                    const Moment& now);
  void Say(std::string_view topic, std::string_view body, std::uint32_t& counter,
           const Moment& now);
  void SayConnection(std::string_view connection_state, const Moment& now);
  void SayState(const Moment& now);
  void SayFactsheet(const Moment& now);
  void SayStateIfChanged(const Moment& now);
  void SayVisualization(const Moment& now);

  Shared shared_;
  Header header_;
  RobotState state_;
  OrderRun run_;
  std::string accepted_order_;        // as it came
  std::vector<std::string> cancels_;  // cancelOrder actions that run
  bool cancels_told_ = false;         // in a state
  std::vector<Running> running_;
  std::vector<Running> retriable_;
  std::unordered_set<std::string> known_;
  std::deque<std::string> known_in_order_;
  std::uint32_t connection_id_ = 0;
  std::uint32_t state_id_ = 0;
  std::uint32_t factsheet_id_ = 0;
  std::uint32_t visualization_id_ = 0;
  std::uint32_t shared_id_ = 0;  // a fault: for all topics
  TimePoint started_;
  TimePoint last_state_;
  TimePoint next_state_;
  std::optional<TimePoint> next_visualization_;
  std::size_t modes_switched_ = 0;  // of the settings' mode_changes
  std::optional<TimePoint> lease_end_;
  bool is_started_ = false;
  bool changed_ = false;
  bool hibernating_ = false;
  bool gone_ = false;
  bool leaving_ = false;         // says OFFLINE after its last state
  bool falling_asleep_ = false;  // says HIBERNATING after its last state
  Utterances* out_ = nullptr;    // while a public function runs
};

}  // namespace fleetpub::simulator
