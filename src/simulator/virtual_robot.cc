#include "simulator/virtual_robot.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "simulator/orders.h"
#include "simulator/permissions.h"

namespace fleetpub::simulator {
namespace {

using std::chrono::steady_clock;

constexpr std::size_t kMostErrors = 10;

}  // namespace

VirtualRobot::VirtualRobot(const Shared& shared, Header header)
    : shared_(shared), header_(std::move(header)), state_(shared.settings.initial) {
  state_.operating_mode = shared_.settings.operating_mode;
  if (shared_.settings.with_order) state_.order = ExampleOrder();
}

Utterance VirtualRobot::Will(const Moment& now) {
  return {"connection",
          Message(header_, connection_id_++, now.wall, ConnectionBody(shared_.terms.broken)),
          shared_.terms.connection_qos, true};
}

void VirtualRobot::Start(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  SayConnection(hibernating_ ? "HIBERNATING" : "ONLINE", now);
  SayFactsheet(now);
  SayState(now);
  Drive(now);
}

void VirtualRobot::End(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
  SayConnection("OFFLINE", now);
  gone_ = true;
}

void VirtualRobot::Receive(std::string_view topic, std::string_view payload, const Moment& now,
                           Utterances& out, const EventCallback& on_event) {
  if (gone_) return;
  out_ = &out;
  if (topic == "instantActions") ReceiveActions(payload, now, on_event);
  if (topic == "order" && !hibernating_) ReceiveOrder(payload, now, on_event);
  if (topic == "zoneSet" && !hibernating_) ReceiveZoneSet(payload, on_event);
  if (topic == "responses" && !hibernating_) ReceiveResponses(payload, now, on_event);
  SayStateIfChanged(now);
}

void VirtualRobot::Tick(const Moment& now, Utterances& out) {
  if (gone_) return;
  out_ = &out;
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
    Drive(now);
  }
  if (order_end_ && *order_end_ <= now.steady && !state_.paused) EndOrder();
  if (next_state_ <= now.steady) changed_ = true;
  SayStateIfChanged(now);
}

steady_clock::time_point VirtualRobot::Due() const {
  if (gone_) return steady_clock::time_point::max();
  steady_clock::time_point due = next_state_;
  if (hibernating_ || shared_.settings.silent) due = steady_clock::time_point::max();
  for (const Running& running : running_) due = std::min(due, running.next);
  if (order_end_ && !state_.paused) due = std::min(due, *order_end_);
  if (lease_end_) due = std::min(due, *lease_end_);
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

void VirtualRobot::ReceiveOrder(std::string_view payload, const Moment& now,
                                const EventCallback& on_event) {
  const Inspection inspection = shared_.inspector.Inspect("order", payload);
  const std::string place = inspection.Place("order");
  std::string fault = inspection.fault;
  if (fault.empty()) fault = AcceptOrder(inspection.message, state_, shared_.terms);
  if (!fault.empty()) {
    on_event({Event::Kind::kFault, fmt::format("{}: {}", place, fault)});
    RobotError error{std::string(inspection.fault.empty() ? shared_.terms.invalid_order
                                                          : shared_.terms.invalid_message),
                     fault,
                     {{"topic", "order"}},
                     Until::kNextOrder};
    if (!inspection.header_id.empty()) {
      error.references.emplace_back("headerId", inspection.header_id);
    }
    return AddError(std::move(error));
  }
  on_event({Event::Kind::kReceived,
            fmt::format("{}: order {}", place, base::Printable(state_.order.id))});
  changed_ = true;
  ForgetErrors(Until::kNextOrder);
  if (shared_.terms.HasZoneSets()) AskForPermissions(inspection.message, state_);
  order_end_.reset();
  Drive(now);
}

// Towards the end of the order, once everything is granted and nothing holds it.
void VirtualRobot::Drive(const Moment& now) {
  const auto expiry = NextExpiry(state_);
  lease_end_.reset();
  if (expiry) lease_end_ = now.steady + (*expiry - now.wall);
  if (!state_.MayDrive()) {
    order_end_.reset();
  } else if (state_.order.Active() && shared_.settings.order_time.count() > 0 && !order_end_) {
    order_end_ = now.steady + shared_.settings.order_time;
  }
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
  Drive(now);
}

void VirtualRobot::EndOrder() {
  FinishOrder(state_);
  order_end_.reset();
  changed_ = true;
}

void VirtualRobot::AddError(RobotError error) {
  changed_ = true;
  std::erase_if(state_.errors, [&](const RobotError& old) {
    return old.type == error.type && old.references == error.references;
  });
  const auto oldest = std::find_if(state_.errors.begin(), state_.errors.end(),
                                   [](const RobotError& old) { return old.until != Until::kEnd; });
  const bool is_full = state_.errors.size() >= kMostErrors && oldest != state_.errors.end();
  if (is_full) state_.errors.erase(oldest);
  state_.errors.push_back(std::move(error));
}

void VirtualRobot::ForgetErrors(Until until) {
  std::erase_if(state_.errors, [&](const RobotError& error) { return error.until == until; });
}

void VirtualRobot::Say(std::string_view topic, std::string_view body, std::uint32_t& counter,
                       const Moment& now) {
  out_->push_back({topic, Message(header_, counter++, now.wall, body)});
}

void VirtualRobot::SayConnection(std::string_view connection_state, const Moment& now) {
  Say("connection", ConnectionBody(connection_state), connection_id_, now);
  out_->back().qos = shared_.terms.connection_qos;
  out_->back().retained = true;
}

void VirtualRobot::SayFactsheet(const Moment& now) {
  if (shared_.factsheet.empty()) return;
  Say("factsheet", shared_.factsheet, factsheet_id_, now);
  out_->back().retained = true;
}

void VirtualRobot::SayState(const Moment& now) {
  changed_ = false;
  if (!state_.order.Active()) state_.requests.clear();  // they were for the order
  next_state_ = now.steady + shared_.settings.state_interval;
  if (shared_.settings.silent || hibernating_) return;
  Say("state", StateBody(state_, shared_.terms), state_id_, now);
}

// The last state comes before the robot falls asleep or leaves.
void VirtualRobot::SayStateIfChanged(const Moment& now) {
  if (changed_) SayState(now);
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
