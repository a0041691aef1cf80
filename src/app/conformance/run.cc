#include "app/conformance/run.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/deliver.h"
#include "base/text.h"
#include "base/uuid.h"
#include "vda5050/messages/user_message.h"

namespace fleetpub::app::conformance {
namespace {

using vda5050::RobotState;
using vda5050::Shown;

bool IsLive(const Heard& heard) { return heard.state.has_value() && !heard.message.retained; }

}  // namespace

CaseFinding Pass(std::string why, std::vector<std::string> evidence) {
  return {Verdict::kPass, std::move(why), std::move(evidence)};
}
CaseFinding Fault(std::string why, std::vector<std::string> evidence) {
  return {Verdict::kFail, std::move(why), std::move(evidence)};
}
CaseFinding Skipped(std::string why) { return {Verdict::kSkipped, std::move(why)}; }
CaseFinding Inconclusive(std::string why, std::vector<std::string> evidence) {
  return {Verdict::kInconclusive, std::move(why), std::move(evidence)};
}

std::string DescribeViolation(std::span<const message::Violation> violations) {
  for (const auto& [path, what] : violations) {
    const bool is_header = path == "/headerId" || path == "/timestamp" || path == "/version" ||
                           path == "/manufacturer" || path == "/serialNumber";
    if (!is_header) return fmt::format("{}: {}", base::Printable(path), what);
  }
  return {};
}

std::string Heard::Evidence() const {
  return header.header_id ? fmt::format("{} headerId {}", topic_name, *header.header_id)
                          : fmt::format("{} of {}", topic_name, base::FormatTimestamp(received));
}

Heard MakeHeard(std::string topic_name, mqtt::Message message, TimePoint at,
                base::WallTime received) {
  Heard heard{.at = at,
              .received = received,
              .topic_name = std::move(topic_name),
              .message = std::move(message),
              .json = {},
              .header = {},
              .state = {}};
  if (auto read = vda5050::ReadMessage(heard.message.payload)) {
    heard.json = *std::move(read);
    heard.header = vda5050::ReadHeader(heard.json);
    if (heard.topic_name == "state") heard.state = vda5050::ReadState(heard.json);
  }
  return heard;
}

bool IsHole(const Heard& before, const Heard& after) {
  return before.header.header_id && after.header.header_id &&
         *after.header.header_id > *before.header.header_id + 1;
}

Run::Run(Subject subject, Wire& wire, schema::Registry& registry)
    : subject_(std::move(subject)), wire_(wire), registry_(registry), began_(wire.Now()) {}

// ---- What was heard ----

std::vector<const Heard*> Run::Of(std::string_view topic_name) const {
  std::vector<const Heard*> found;
  for (const Heard& one : heard_) {
    if (one.topic_name == topic_name) found.push_back(&one);
  }
  return found;
}

std::vector<const Heard*> Run::StatesSince(std::size_t mark) const {
  std::vector<const Heard*> found;
  for (std::size_t i = mark; i < heard_.size(); ++i) {
    if (IsLive(heard_[i])) found.push_back(&heard_[i]);
  }
  return found;
}

bool Run::HasHole(std::size_t mark) const {
  auto states = StatesSince(mark);
  for (std::size_t i = mark; i-- > 0;) {
    if (!IsLive(heard_[i])) continue;
    states.insert(states.begin(), &heard_[i]);
    break;
  }
  return std::adjacent_find(states.begin(), states.end(), [](const Heard* a, const Heard* b) {
           return IsHole(*a, *b);
         }) != states.end();
}

void Run::Take(std::string topic_name, mqtt::Message message) {
  Heard heard = MakeHeard(std::move(topic_name), std::move(message), wire_.Now(), wire_.WallNow());
  if (heard.topic_name == "factsheet" && heard.json.IsObject()) {
    subject_.factsheet = vda5050::ReadFactsheet(heard.json);
  }
  heard_.push_back(std::move(heard));
  if (!IsLive(heard_.back())) return;
  last_state_ = &heard_.back();
  CheckState(*last_state_->state);
}

void Run::CheckState(const RobotState& state) {
  for (const vda5050::RobotError& error : state.errors) {
    if (error.level == "FATAL") Abort("the robot reports FATAL " + Shown(error.type));
  }
  if (vda5050::IsEmergencyStopped(state)) Abort("the robot's emergency stop is active");
  if (mode_.empty()) mode_ = state.operating_mode;
  if (!state.operating_mode.empty() && state.operating_mode != mode_) {
    Abort(fmt::format("the operating mode changed from {} to {}", Shown(mode_),
                      Shown(state.operating_mode)));
  }
}

void Run::Abort(std::string why) {
  if (abort_.empty()) abort_ = std::move(why);
}

// Whether nothing is sent and waited for any more.
bool Run::IsOver() {
  if (!wire_.IsStopped()) return false;
  if (!stopped_at_) {
    stopped_at_ = wire_.Now();
    Abort("interrupted");
  }
  return !takes_back_ || wire_.Now() >= *stopped_at_ + kTakingBack;
}

// Whether something came.
bool Run::Step(TimePoint until) {
  if (IsOver()) return false;
  auto next = wire_.Next(until);
  if (next) Take(std::move(next->first), std::move(next->second));
  return next.has_value();
}

void Run::Listen(std::chrono::nanoseconds time) {
  const TimePoint until = wire_.Now() + time;
  while (wire_.Now() < until && !IsOver()) (void)Step(until);
}

StateTest ShowsEnd(const std::string& id) {
  return [id](const RobotState& state) {
    const auto* action = vda5050::FindActionState(state, id);
    return action != nullptr && vda5050::IsTerminal(action->status);
  };
}

Awaited Run::Await(const StateTest& test, std::chrono::nanoseconds limit) {
  return AwaitSince(mark(), wire_.Now(), test, limit);
}

Awaited Run::AwaitSince(std::size_t mark, TimePoint from, const StateTest& test,
                        std::chrono::nanoseconds limit) {
  Awaited awaited;
  const TimePoint end = from + limit;
  const TimePoint last = end + kLongestSilence;
  for (std::size_t i = mark;;) {
    for (; i < heard_.size(); ++i) {
      const Heard& one = heard_[i];
      if (!IsLive(one)) continue;
      awaited.has_hole = HasHole(mark);
      if (test(*one.state)) {
        awaited.found = &one;
        awaited.is_late = one.at > end;
        return awaited;
      }
      if (one.at >= end) {
        awaited.last = &one;
        return awaited;
      }
    }
    if (IsOver()) return awaited;
    if (wire_.Now() >= last) {
      Abort("the robot has been silent for too long");
      return awaited;
    }
    (void)Step(last);
  }
}

void Run::Refresh() {
  const std::size_t before = mark();
  const TimePoint from = Now();
  const std::string id = Do("stateRequest");
  (void)AwaitSince(before, from, ShowsEnd(id), kNextState);
}

Awaited Run::AwaitOwnActions() {
  const auto shows_end = ShowsEnd(Do("stateRequest"));
  const auto has_ended = [&](const vda5050::ActionState& action) {
    return !IsInstant(action.id) || vda5050::IsTerminal(action.status);
  };
  return Await([&](const RobotState& state) {
    return shows_end(state) &&
           std::all_of(state.action_states.begin(), state.action_states.end(), has_ended) &&
           std::all_of(state.instant_action_states.begin(), state.instant_action_states.end(),
                       has_ended);
  });
}

CaseFinding Run::Missing(const Awaited& awaited, std::string what) {
  if (awaited.IsRefuted()) return Fault(std::move(what), {awaited.last->Evidence()});
  if (awaited.has_hole) return Inconclusive(what + ", but states are missing");
  return Inconclusive(what + ", as no state came");
}

// ---- What is said ----

void Run::Send(Result<message::Command> command, Intent intent) {
  if (IsOver()) return;
  if (!command) return Abort(command.error().message);
  if (intent == Intent::kValid) {
    if (const auto valid = ValidateCommand(*command, registry_); !valid) {
      return Abort("not sent: " + valid.error().message);
    }
  }
  if (const auto sent = wire_.Send(*command); !sent) Abort(sent.error().message);
}

std::string Run::MakeId(std::string_view what) {
  const bool is_number = subject_.factsheet && subject_.factsheet->limits.id_numerical_only;
  static const std::string kOnce = base::RandomUuid().substr(0, 8);
  ++made_ids_;
  return is_number ? fmt::format("{}{:04}", std::stoul(kOnce, nullptr, 16), made_ids_)
                   : fmt::format("{}-{}-{}", what, kOnce, made_ids_);
}

std::string Run::Do(std::string_view type, std::vector<vda5050::Parameter> parameters,
                    std::string id) {
  vda5050::InstantAction action{.type = std::string(type),
                                .id = id.empty() ? MakeId("conform") : std::move(id),
                                .descriptor = {},
                                .blocking_type = {},
                                .parameters = std::move(parameters)};
  instant_ids_.insert(action.id);
  Send(vda5050::BuildInstantActions(subject_.address, subject_.dialect, {&action, 1}),
       Intent::kValid);
  return action.id;
}

void Run::SendOrder(const base::JsonDocument& order, Intent intent) {
  Send(vda5050::BuildUserMessage(subject_.address, subject_.dialect, "order", order,
                                 vda5050::HeaderMismatch::kReplace),
       intent);
}

void Run::SendGarbage() {
  const vda5050::InstantAction action{.type = "stateRequest",
                                      .id = MakeId("conform"),
                                      .descriptor = {},
                                      .blocking_type = {},
                                      .parameters = {}};
  auto command = vda5050::BuildInstantActions(subject_.address, subject_.dialect, {&action, 1});
  if (command) command->payload.rest.resize(command->payload.rest.size() / 2);
  Send(std::move(command), Intent::kWrong);
}

std::optional<bool> Run::Knows(std::string_view type, std::string_view scope) const {
  if (!subject_.factsheet || subject_.factsheet->actions.empty()) return std::nullopt;
  const auto* action = vda5050::FindAction(*subject_.factsheet, type);
  if (action == nullptr) return false;
  return action->scopes.empty() ||
         std::find(action->scopes.begin(), action->scopes.end(), scope) != action->scopes.end();
}

}  // namespace fleetpub::app::conformance
