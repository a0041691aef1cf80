#include "app/follow_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "app/deliver.h"
#include "app/dry_run.h"
#include "app/order_update.h"
#include "app/robot_listener.h"
#include "base/text.h"
#include "base/time.h"
#include "schema/schema.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/tracking/reception.h"

namespace fleetpub::app {
namespace {

using base::FindArray;
using message::CommandStatus;
using std::chrono::steady_clock;
using vda5050::RobotState;
using vda5050::Shown;
using Value = base::JsonValue;

std::uint32_t ReadSequenceId(const Value& leg) {
  return base::UintMember(leg, "sequenceId").value_or(0);
}

// Nodes or edges by their sequenceId, as the messages up to this update leave them: each one replaces
// what lies behind its first.
std::vector<std::string> MergeLegs(const OrderHistory& history, std::uint32_t update_id,
                                   std::string_view list) {
  std::map<std::uint32_t, std::string> legs;
  for (const SentOrder& sent : history.sent) {
    const Value* array = FindArray(sent.message, list);
    const Value* nodes = FindArray(sent.message, "nodes");
    if (sent.update_id > update_id || array == nullptr || nodes == nullptr || nodes->Empty()) {
      continue;
    }
    legs.erase(legs.lower_bound(ReadSequenceId((*nodes)[0])), legs.end());
    for (const Value& leg : array->GetArray()) legs[ReadSequenceId(leg)] = base::ToJson(leg);
  }
  std::vector<std::string> merged;
  merged.reserve(legs.size());
  for (auto& [id, leg] : legs) merged.push_back(std::move(leg));
  return merged;
}

// Up to 2.1 one list has the order's actions and the instant ones.
bool IsOnlyInstant(const vda5050::ActionState& action, vda5050::Version version) {
  const vda5050::ActionSpec* spec = vda5050::FindAction(version, action.type);
  return spec != nullptr && spec->scopes.instant && !spec->scopes.node && !spec->scopes.edge;
}

// As much of somebody else's order as its state shows.
base::JsonDocument DescribeByState(const RobotState& state, vda5050::Version version) {
  std::vector<std::string> nodes;
  const auto add = [&](std::string_view id, std::uint32_t sequence_id, const std::string& actions) {
    nodes.push_back(fmt::format(R"({{"nodeId":{},"sequenceId":{},"released":true,"actions":[{}]}})",
                                base::JsonString(id), sequence_id, actions));
  };
  std::string actions;
  for (const vda5050::ActionState& action : state.action_states) {
    if (IsOnlyInstant(action, version)) continue;
    actions += fmt::format(R"({}{{"actionId":{},"actionType":{}}})", actions.empty() ? "" : ",",
                           base::JsonString(action.id), base::JsonString(action.type));
  }
  add(state.last_node_id, state.last_node_sequence_id.value_or(0), actions);
  for (const vda5050::NodeState& node : state.nodes) {
    if (node.sequence_id > state.last_node_sequence_id.value_or(0)) {
      add(node.id, node.sequence_id, "");
    }
  }
  return vda5050::MakeOrder(state.order_id, state.order_update_id.value_or(0), "", nodes, {});
}

// The robot's state of now; nothing, if it is another message, or one that proves nothing.
std::optional<RobotState> TakeLiveState(const message::Incoming& message,
                                        const RobotListener& listener,
                                        vda5050::Reception& reception) {
  const bool is_state = message.topic == listener.state_topic();
  if (!is_state) static_cast<void>(reception.TakeConnection(message));
  auto state = is_state ? reception.TakeState(message) : std::nullopt;
  return message.retained ? std::nullopt : std::move(state);
}

// Until one of its states is the one that is wanted. Whether that came.
Result<bool> AwaitState(RobotListener& listener, const Observer& observer,
                        const std::function<bool(const RobotState& state)>& is_wanted) {
  vda5050::Reception reception(listener.address(), listener.dialect());
  bool came = false;
  auto read = listener.subscription().Read(
      [&](const mqtt::Message& message) {
        const auto state = TakeLiveState(
            {.topic = message.topic, .payload = message.payload, .retained = message.retained},
            listener, reception);
        came = state && is_wanted(*state);
        return came;
      },
      [&]() -> Result<bool> { return !observer.IsStopped(); });
  if (!read) return Fail(std::move(read.error()));
  listener.subscription().Disconnect();
  return came;
}

struct MadeOrder {
  message::Command command;
  std::vector<std::string> notes;
};

// Of what the robot says of itself, and valid. `state`: null: none came.
Result<MadeOrder> MakeOrderFor(const RobotListener& listener, const OrderTask& task,
                               const RobotState* state, std::optional<std::uint32_t> header_id,
                               const Environment& environment) {
  const auto& factsheet = listener.robot().second.factsheet;
  auto composed = ComposeOrder(task,
                               {.address = listener.address(),
                                .dialect = listener.dialect(),
                                .factsheet = task.check ? factsheet.get() : nullptr,
                                .state = state,
                                .brokers = listener.server().ListSite()},
                               environment.ledger);
  if (!composed) return Fail(std::move(composed.error()));
  auto command = BuildOrder(*composed, listener.address(), listener.dialect(), header_id);
  if (!command) return Fail(std::move(command.error()));
  schema::Registry registry(environment.schema_directory);
  if (auto valid = ValidateCommand(*command, registry); !valid) return Fail(valid.error());
  return MadeOrder{*std::move(command), std::move(composed->notes)};
}

class OrderFollower {
 public:
  OrderFollower(const FollowRequest& request, const Environment& environment, Observer& observer,
                RobotListener& listener)
      : request_(request),
        environment_(environment),
        observer_(observer),
        listener_(listener),
        reception_(listener.address(), listener.dialect()),
        start_(steady_clock::now()) {}

  Result<message::Report> Run() {
    TellWait("waiting for the state of " + listener_.name());
    auto read =
        listener_.subscription().Read([&](const mqtt::Message& message) { return Take(message); },
                                      [&]() -> Result<bool> {
                                        if (auto ok = KeepReleased(); !ok)
                                          observer_.Warn(ok.error().message);
                                        return !observer_.IsStopped();
                                      });
    observer_.Wait("");
    if (!read) return Fail(std::move(read.error()));
    if (!fault_) return Fail(std::move(fault_.error()));
    listener_.subscription().Disconnect();
    message::Report report = MakeReport();
    if (request_.keep_released) RecordEnd(report);
    return report;
  }

 private:
  void TellWait(const std::string& what) {
    observer_.Wait(what, listener_.end(), "Ctrl-C stops following, not the robot");
  }

  // Whether it was the last that is wanted. An update makes the order another one to follow.
  bool Take(const mqtt::Message& message) {
    const message::Incoming incoming{
        .topic = message.topic, .payload = message.payload, .retained = message.retained};
    if (auto state = TakeLiveState(incoming, listener_, reception_)) {
      state_ = std::move(state);
      const bool is_update =
          state_->order_id == order_id_ && state_->order_update_id.value_or(0) != update_id_;
      if (is_update) tracker_.reset();
      if (tracker_ == nullptr) {
        fault_ = Begin();
        if (!fault_) return true;
      }
    }
    if (tracker_ == nullptr) return false;
    tracker_->Receive(incoming);
    for (std::string& line : tracker_->TakeNews()) {
      if (line != last_line_) observer_.Info(line);
      last_line_ = std::move(line);
    }
    const message::Progress& progress = tracker_->progress();
    TellWait(fmt::format("{}: {}", listener_.name(), base::Printable(progress.message)));
    return progress.ended;
  }

  Status Begin() {
    if (state_->order_id.empty()) {
      return Fail(ErrorKind::kPreflight, fmt::format("{} has no order", listener_.name()));
    }
    const bool is_first = order_id_.empty();
    order_id_ = state_->order_id;
    update_id_ = state_->order_update_id.value_or(0);
    base::JsonDocument order = FindOrder();
    auto tracker = vda5050::TrackTakenOrder(listener_.address(), listener_.dialect(), order);
    if (!tracker) return Fail(std::move(tracker.error()));
    tracker_ = *std::move(tracker);
    tracker_->Published(1);
    if (is_first) {
      observer_.Info(fmt::format("{}  order {}{}", listener_.name(), Shown(order_id_),
                                 update_id_ == 0 ? "" : fmt::format(" update {}", update_id_)));
    }
    return {};
  }

  [[nodiscard]] base::JsonDocument FindOrder() {
    row_ = 0;
    const auto by_state = [this] { return DescribeByState(*state_, listener_.dialect().version); };
    const auto ledger = environment_.ledger(ledger::OpenMode::kReadOnly);
    if (!ledger) return by_state();
    const auto history = ReadOrderHistory(**ledger, listener_.server().ListSite(),
                                          listener_.address().ToString(), state_->order_id);
    const SentOrder* const sent = history ? history->Find(*state_) : nullptr;
    if (sent == nullptr) return by_state();
    row_ = sent->row;
    return vda5050::MakeOrder(order_id_, update_id_, "", MergeLegs(*history, update_id_, "nodes"),
                              MergeLegs(*history, update_id_, "edges"));
  }

  // --- Releasing

  // Once for each update that the robot has taken: what was sent meanwhile may be on its way.
  Status KeepReleased() {
    if (!request_.keep_released || !state_ || tracker_ == nullptr) return {};
    const std::uint32_t update_id = state_->order_update_id.value_or(0);
    if (released_for_ && *released_for_ >= update_id && steady_clock::now() < retry_) return {};
    std::size_t ahead = 0;
    std::size_t horizon = 0;
    for (const vda5050::NodeState& node : state_->nodes) {
      if (node.sequence_id <= state_->last_node_sequence_id.value_or(0)) continue;
      ++(node.released ? ahead : horizon);
    }
    const std::size_t wanted = std::max<std::size_t>(*request_.keep_released, 1);
    const bool asks = state_->new_base_request.value_or(false);
    if (horizon == 0 || (ahead >= wanted && !asks)) return {};
    released_for_ = update_id;
    constexpr auto kRetryAfter = std::chrono::seconds(5);
    retry_ = steady_clock::now() + kRetryAfter;
    return Release(ahead >= wanted ? 1 : wanted - ahead);
  }

  Status Release(std::size_t nodes) {
    OrderTask task{.kind = OrderKind::kRelease, .path = {}, .site = nullptr, .order_id = {}};
    task.release = nodes;
    const auto made = MakeOrderFor(listener_, task, &*state_, {}, environment_);
    if (!made) return Fail(made.error());
    Status sent = listener_.Send(made->command, request_.qos);
    if (sent) {
      for (const std::string& note : made->notes) observer_.Info(note);
    }
    return sent;
  }

  // --- The end

  [[nodiscard]] message::Report MakeReport() const {
    message::Report report;
    report.target = listener_.address().ToString();
    report.protocol = "vda5050";
    report.version = vda5050::GetFacts(listener_.dialect().version).name;
    report.topic = listener_.state_topic();
    report.actions = {{"order", order_id_}};
    report.elapsed = steady_clock::now() - start_;
    report.status = CommandStatus::kTimeout;
    report.message =
        fmt::format("it sent no state within {}", base::FormatElapsed(request_.timeout));
    if (tracker_ != nullptr) {
      const message::Progress& progress = tracker_->progress();
      report.status = progress.ended ? progress.status : CommandStatus::kTimeout;
      report.message = progress.message;
    }
    if (report.status == CommandStatus::kTimeout && observer_.IsStopped()) {
      report.status = CommandStatus::kInterrupted;
    }
    report.error = message::ToErrorKind(report.status);
    return report;
  }

  // At the message of which the end is: it was known to be accepted so far.
  void RecordEnd(const message::Report& report) {
    if (row_ == 0) return;
    const ledger::StatusUpdate end{
        .row = row_, .status = std::string(GetName(report.status)), .detail = report.message};
    const auto ledger = environment_.ledger(ledger::OpenMode::kCreate);
    const Status recorded = ledger ? (*ledger)->RecordOutcomes({&end, 1}) : Fail(ledger.error());
    if (!recorded) observer_.Warn(recorded.error().message);
  }

  const FollowRequest& request_;
  const Environment& environment_;
  Observer& observer_;
  RobotListener& listener_;
  vda5050::Reception reception_;
  steady_clock::time_point start_;
  std::unique_ptr<message::ResponseTracker> tracker_;
  std::optional<RobotState> state_;  // the last live one
  std::string order_id_;
  std::uint32_t update_id_ = 0;
  std::int64_t row_ = 0;  // of the ledger: the message that the robot has; 0: not known
  std::string last_line_;
  std::optional<std::uint32_t> released_for_;
  steady_clock::time_point retry_;
  Status fault_;
};

}  // namespace

Result<message::Report> FollowOrder(const FollowRequest& request, const Environment& environment,
                                    Observer& observer) {
  return WithListener(request, environment, observer, {}, [&](RobotListener& listener) {
    return OrderFollower(request, environment, observer, listener).Run();
  });
}

Status TryReplacing(const OrderTask& task, std::optional<std::uint32_t> header_id,
                    const FollowRequest& request, const Environment& environment,
                    Observer& observer) {
  bool is_there = false;
  auto tried =
      WithListener(request, environment, observer, {}, [&](RobotListener& listener) -> Status {
        is_there = true;
        std::optional<RobotState> state;
        observer.Wait("waiting for the state of " + listener.name(), listener.end());
        auto came = AwaitState(listener, observer, [&](const RobotState& live) {
          state = live;
          return true;
        });
        observer.Wait("");
        if (!came) return Fail(std::move(came.error()));
        const auto made =
            MakeOrderFor(listener, task, state ? &*state : nullptr, header_id, environment);
        if (!made) return Fail(made.error());
        auto dry_run = DryRun::Open(environment.ledger);
        if (!dry_run) return Fail(std::move(dry_run.error()));
        const auto report = dry_run->Report(made->command);
        return report ? Status() : Fail(report.error());
      });
  // Who cancels says better of whom nothing is known, or who is not there.
  if (!tried && !is_there && tried.error().kind == ErrorKind::kPreflight) return {};
  return tried;
}

Status AwaitIdle(const FollowRequest& request, const Environment& environment, Observer& observer) {
  return WithListener(request, environment, observer, {}, [&](RobotListener& listener) -> Status {
    observer.Wait(fmt::format("waiting until {} is idle", listener.name()), listener.end());
    const auto is_idle =
        AwaitState(listener, observer, [](const RobotState& state) { return !IsUnderWay(state); });
    observer.Wait("");
    if (!is_idle) return Fail(is_idle.error());
    if (*is_idle) return {};
    return Fail(ErrorKind::kUnconfirmed,
                fmt::format("{} still shows an order under way; the new one was not sent",
                            listener.name()));
  });
}

}  // namespace fleetpub::app
