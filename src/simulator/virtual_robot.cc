#include "simulator/virtual_robot.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "simulator/permissions.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::steady_clock;

// The topic level of the major version, which some robots take for the version.
std::string MajorLevel(const Header& header) {
  return "v" + header.version.substr(0, header.version.find('.'));
}

}  // namespace

VirtualRobot::VirtualRobot(const Shared& shared, Header header)
    : shared_(shared),
      header_(std::move(header)),
      state_(shared.settings.initial),
      run_(shared.settings, shared.terms) {
  state_.operating_mode = shared_.settings.operating_mode;
  if (shared_.settings.with_order) state_.order = ExampleOrder();
  if (Has(Fault::kHeaderVersion)) header_.version = MajorLevel(header_);
  if (Has(Fault::kHeaderName)) header_.serial_number.clear();
  header_.has_zone = !Has(Fault::kLocalTime);
}

Utterance VirtualRobot::Will(const Moment& now) {
  std::string_view broken = shared_.terms.broken;
  if (Has(Fault::kOldBroken)) {
    broken = broken == "CONNECTIONBROKEN" ? "CONNECTION_BROKEN" : "CONNECTIONBROKEN";
  }
  return {"connection", Compose(ConnectionBody(broken), connection_id_, now),
          Has(Fault::kConnectionQos0) ? mqtt::Qos::kAtMostOnce : shared_.terms.connection_qos,
          !Has(Fault::kConnectionNotRetained)};
}

// Without a connection it has driven on (1.1–2.1 §6.2, 3.0 §4.1).
void VirtualRobot::Start(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  if (!is_started_) {
    started_ = now.steady;
    if (shared_.settings.visualization_interval.count() > 0) next_visualization_ = now.steady;
  }
  CatchUp(now, false);
  if (!is_started_ || !Has(Fault::kNoOnline)) {
    SayConnection(hibernating_ ? "HIBERNATING" : "ONLINE", now);
  }
  is_started_ = true;
  SayFactsheet(now);
  NoteLeases(now);
  if (run_.Advance(state_, now.steady)) changed_ = true;
  SayState(now);
}

void VirtualRobot::End(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  if (!Has(Fault::kNoOffline)) SayConnection("OFFLINE", now);
  gone_ = true;
}

void VirtualRobot::Receive(std::string_view topic, std::string_view payload, const Moment& now,
                           Utterances& out, const EventCallback& on_event) {
  if (gone_) return;
  out_ = &out;
  CatchUp(now, true);
  if (topic == "instantActions") ReceiveActions(payload, now, on_event);
  if (topic == "order" && !hibernating_) ReceiveOrder(payload, now, on_event);
  if (topic == "zoneSet" && !hibernating_) ReceiveZoneSet(payload, on_event);
  if (topic == "responses" && !hibernating_) ReceiveResponses(payload, now, on_event);
  Proceed(now);
}

void VirtualRobot::Tick(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  CatchUp(now, true);
  // An action that ends may begin another one: by index.
  for (std::size_t i = 0; i < running_.size();) {
    if (running_[i].next > now.steady) {
      ++i;
      continue;
    }
    Running running = std::move(running_[i]);
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    Advance(running, now);
  }
  if (lease_end_ && *lease_end_ <= now.steady) {
    if (ExpireLeases(state_, now.wall)) changed_ = true;
    NoteLeases(now);
  }
  const auto& modes = shared_.settings.mode_changes;
  while (modes_switched_ < modes.size() && started_ + modes[modes_switched_].after <= now.steady) {
    ApplyMode(modes[modes_switched_++].mode);
  }
  if (next_state_ <= now.steady) changed_ = true;
  Proceed(now);
  if (next_visualization_ && *next_visualization_ <= now.steady) SayVisualization(now);
}

// Nodes and actions one by one, each at its time and with its state.
void VirtualRobot::CatchUp(const Moment& now, bool is_heard) {
  for (TimePoint due = run_.Due(state_); due <= now.steady; due = run_.Due(state_)) {
    const Moment then{
        due, now.wall - std::chrono::duration_cast<base::WallTime::duration>(now.steady - due)};
    if (is_heard) {
      Proceed(then);
    } else {
      (void)run_.Advance(state_, then.steady);
    }
  }
}

void VirtualRobot::Proceed(const Moment& now) {
  if (run_.Advance(state_, now.steady)) changed_ = true;
  if (FinishCancels()) changed_ = true;
  SayStateIfChanged(now);
  if (!FinishCancels()) return;
  changed_ = true;
  SayStateIfChanged(now);
}

steady_clock::time_point VirtualRobot::Due() const {
  if (gone_) return steady_clock::time_point::max();
  const Settings& settings = shared_.settings;
  steady_clock::time_point due = next_state_;
  if (changed_) due = std::min(due, last_state_ + settings.min_state_interval);
  if (hibernating_ || settings.silent) due = steady_clock::time_point::max();
  for (const Running& running : running_) due = std::min(due, running.next);
  due = std::min(due, run_.Due(state_));
  if (lease_end_) due = std::min(due, *lease_end_);
  if (next_visualization_) due = std::min(due, *next_visualization_);
  if (modes_switched_ < settings.mode_changes.size()) {
    due = std::min(due, started_ + settings.mode_changes[modes_switched_].after);
  }
  return due;
}

void VirtualRobot::RefuseMessage(const Inspection& inspection, std::string_view topic) {
  RobotError error{std::string(shared_.terms.invalid_message), inspection.fault, {}};
  error.references.emplace_back("topic", topic);
  if (!inspection.header_id.empty())
    error.references.emplace_back("headerId", inspection.header_id);
  for (const ReceivedAction& action : inspection.actions) {
    if (!action.call.id.empty()) error.references.emplace_back("actionId", action.call.id);
  }
  AddError(std::move(error));
}

// The message; told as an error when it cannot be used.
Inspection VirtualRobot::InspectFor(std::string_view topic, std::string_view payload,
                                    std::string_view error_type, const EventCallback& on_event) {
  Inspection inspection = shared_.inspector.Inspect(topic, payload);
  if (inspection.fault.empty()) return inspection;
  on_event({Event::Kind::kFault, fmt::format("{}: {}", inspection.Place(topic), inspection.fault)});
  RobotError error{std::string(error_type), inspection.fault, {{"topic", std::string(topic)}}};
  if (!inspection.header_id.empty()) {
    error.references.emplace_back("headerId", inspection.header_id);
  }
  AddError(std::move(error));
  return inspection;
}

void VirtualRobot::ReceiveZoneSet(std::string_view payload, const EventCallback& on_event) {
  const Inspection inspection =
      InspectFor("zoneSet", payload, shared_.terms.invalid_message, on_event);
  if (!inspection.fault.empty()) return;
  const std::string fault = AcceptZoneSet(inspection.message, state_);
  const std::string place = inspection.Place("zoneSet");
  const std::string id(base::StringMember(inspection.message["zoneSet"], "zoneSetId"));
  changed_ = true;
  if (fault.empty()) {
    return on_event(
        {Event::Kind::kReceived, fmt::format("{}: zone set {}", place, base::Printable(id))});
  }
  on_event({Event::Kind::kFault, fmt::format("{}: {}", place, fault)});
  AddError({std::string(shared_.terms.duplicate_zone_set), fault, {{"zoneSetId", id}}});
}

void VirtualRobot::ReceiveResponses(std::string_view payload, const Moment& now,
                                    const EventCallback& on_event) {
  const Inspection inspection =
      InspectFor("responses", payload, shared_.terms.invalid_message, on_event);
  if (!inspection.fault.empty()) return;
  const std::string place = inspection.Place("responses");
  for (const std::string& id : TakeResponses(inspection.message, state_)) {
    const std::string fault = fmt::format("there is no request {}", base::Printable(id));
    on_event({Event::Kind::kFault, fmt::format("{}: {}", place, fault)});
    AddError({std::string(shared_.terms.invalid_message), fault, {{"requestId", id}}});
  }
  on_event({Event::Kind::kReceived, place});
  changed_ = true;
  NoteLeases(now);
}

void VirtualRobot::AddError(RobotError error) {
  changed_ = true;
  simulator::AddError(state_, std::move(error));
}

std::string VirtualRobot::Compose(std::string_view body, std::uint32_t& counter,
                                  const Moment& now) {
  std::uint32_t id = Has(Fault::kHeaderIdShared) ? shared_id_++ : counter;
  ++counter;
  if (Has(Fault::kHeaderIdZero)) id = 0;
  if (Has(Fault::kHeaderIdRestart)) id %= 10;
  return Message(header_, id, now.wall, body);
}

void VirtualRobot::Say(std::string_view topic, std::string_view body, std::uint32_t& counter,
                       const Moment& now) {
  out_->push_back({topic, Compose(body, counter, now)});
}

void VirtualRobot::SayConnection(std::string_view connection_state, const Moment& now) {
  Say("connection", ConnectionBody(connection_state), connection_id_, now);
  if (!Has(Fault::kConnectionQos0)) out_->back().qos = shared_.terms.connection_qos;
  out_->back().retained = !Has(Fault::kConnectionNotRetained);
}

void VirtualRobot::SayFactsheet(const Moment& now) {
  if (shared_.factsheet.empty()) return;
  Say("factsheet", shared_.factsheet, factsheet_id_, now);
  out_->back().retained = !Has(Fault::kFactsheetNotRetained);
}

void VirtualRobot::SayState(const Moment& now) {
  changed_ = false;
  cancels_told_ = true;
  if (!state_.order.Active()) state_.requests.clear();  // they were for the order
  last_state_ = now.steady;
  next_state_ = now.steady + shared_.settings.state_interval;
  if (shared_.settings.silent || hibernating_) return;
  run_.Locate(state_, now.steady);
  if (Has(Fault::kLoseStates) && state_id_ % 3 == 2) {
    ++state_id_;
  } else {
    Say("state", StateBody(state_, shared_.terms, shared_.settings.faults), state_id_, now);
  }
  if (Has(Fault::kBriefRejection)) ForgetErrors(state_, Until::kNextOrder);
  if (Has(Fault::kForgetInstantActions)) {
    std::erase_if(state_.instant_actions,
                  [](const ActionState& action) { return IsEnded(action.status); });
  }
}

void VirtualRobot::SayVisualization(const Moment& now) {
  next_visualization_ = now.steady + shared_.settings.visualization_interval;
  if (shared_.settings.silent || hibernating_ || Has(Fault::kNoVisualization)) return;
  run_.Locate(state_, now.steady);
  const bool refers = !Has(Fault::kVisualizationWithoutReference);
  Say("visualization",
      VisualizationBody(state_, shared_.terms,
                        refers ? std::optional(state_id_ - 1) : std::nullopt),
      visualization_id_, now);
}

// The last state comes before the robot falls asleep or leaves. What comes too early for the next
// one waits for it.
void VirtualRobot::SayStateIfChanged(const Moment& now) {
  if (Has(Fault::kNoStateOnChange) && now.steady < next_state_) changed_ = false;
  const bool is_last = falling_asleep_ || leaving_;
  const bool is_early = now.steady < last_state_ + shared_.settings.min_state_interval;
  if (changed_ && (is_last || !is_early)) SayState(now);
  if (falling_asleep_) {
    falling_asleep_ = false;
    hibernating_ = true;
    SayConnection("HIBERNATING", now);
  }
  if (leaving_) {
    leaving_ = false;
    SayConnection("OFFLINE", now);
    gone_ = true;
  }
}

}  // namespace fleetpub::simulator
