#include "simulator/platform.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/text.h"
#include "delivery/topic_filter.h"
#include "delivery/validate.h"
#include "soar/message.h"

namespace fleetpub::simulator {
namespace {

using base::FindMember;
using base::StringMember;
using Value = base::JsonValue;
using soar::Level;
using soar::MessageType;
using std::chrono::steady_clock;

constexpr std::size_t kMostKnown = 10'000;  // message ids that are remembered
constexpr std::size_t kMostTasks = 1'000;   // on their way at once
constexpr double kBattery = 80;

std::string ReadJson(const Value& object, std::string_view name) {
  const Value* value = FindMember(object, name);
  return value == nullptr ? std::string() : base::ToJson(*value);
}

// Somewhere at sea.
constexpr double kHomeLatitude = 50.35;
constexpr double kHomeLongitude = -4.2;

}  // namespace

VirtualPlatform::VirtualPlatform(const Shared& shared, soar::Destination self, int number)
    : shared_(shared),
      self_(std::move(self)),
      platform_id_(fmt::format("{}", number)),
      place_{kHomeLatitude, kHomeLongitude},
      next_status_(steady_clock::time_point::max()) {}

void VirtualPlatform::Start(const Moment& now, std::vector<mqtt::Message>& out) {
  SayStatus(now, out);
}

void VirtualPlatform::Receive(const mqtt::Message& message, const Moment& now,
                              std::vector<mqtt::Message>& out, const EventCallback& on_event) {
  const auto fault = [&](std::string_view what) {
    on_event({Event::Kind::kFault, fmt::format("{}: {}", message.topic, what)});
  };
  if (message.retained) return fault("a command must not be retained: it is not obeyed");
  const auto document = base::ParseJson(message.payload);
  if (!document) return fault(document.error().message);
  const auto findings = delivery::Check(*document, shared_.schema, {});
  if (!findings.errors.empty()) return fault(delivery::Describe(findings));
  const Value& payload = *FindMember(*document, "payload");
  const std::string_view type = StringMember(payload, "message_type");
  if (type != GetName(MessageType::kMissionPlan) &&
      type != GetName(MessageType::kPlanningConfiguration)) {
    return;  // what others report is nobody's command
  }
  auto task = ReadTask(*document);
  if (!task) return fault(task.error().message);
  on_event({Event::Kind::kReceived, fmt::format("{} {}", type, task->message_id)});
  if (tasks_.size() >= kMostTasks) return fault("too much is under way: it is not obeyed");
  if (shared_.settings.silent || !Remember(task->message_id)) return;
  task->due = now.steady;
  tasks_.push_back(*std::move(task));
  Tick(now, out);
}

Result<VirtualPlatform::Task> VirtualPlatform::ReadTask(const Value& message) const {
  const Value& header = *FindMember(message, "header");
  const Value& payload = *FindMember(message, "payload");
  Task task;
  task.message_id = StringMember(header, "message_ID");
  if (task.message_id.empty()) {
    return Fail(ErrorKind::kInvalid, "without a message_ID it cannot be acknowledged");
  }
  const std::string_view reply_to = self_.platform ? self_.name : StringMember(header, "source");
  auto destination =
      soar::ParseDestination(reply_to, shared_.settings.prefix, MessageType::kAcknowledgement);
  if (!destination) return Fail(std::move(destination.error()));
  task.reply_to = *std::move(destination);
  if (StringMember(payload, "message_type") != GetName(MessageType::kMissionPlan)) return task;
  task.plan_id = ReadJson(payload, "autonomy_engine_plan_ID");
  task.platform_id = ReadJson(payload, "platform_ID");
  const Value* plan = FindMember(payload, "plan");
  if (plan != nullptr && plan->IsArray() && !plan->Empty()) {
    const Value& last = (*plan)[plan->Size() - 1];
    const Value* latitude = FindMember(last, "latitude_waypoint");
    const Value* longitude = FindMember(last, "longitude_waypoint");
    if (latitude != nullptr && longitude != nullptr) {
      task.last = Place{latitude->GetDouble(), longitude->GetDouble()};
    }
  }
  return task;
}

bool VirtualPlatform::Remember(const std::string& message_id) {
  if (!known_.insert(message_id).second) return false;
  known_in_order_.push_back(message_id);
  if (known_in_order_.size() > kMostKnown) {
    known_.erase(known_in_order_.front());
    known_in_order_.pop_front();
  }
  return true;
}

void VirtualPlatform::Tick(const Moment& now, std::vector<mqtt::Message>& out) {
  std::vector<Task> left;
  for (Task& task : tasks_) {
    bool goes_on = true;
    while (goes_on && task.due <= now.steady) goes_on = Advance(task, now, out);
    if (goes_on) left.push_back(std::move(task));
  }
  tasks_ = std::move(left);
  if (next_status_ <= now.steady) SayStatus(now, out);
}

bool VirtualPlatform::Advance(Task& task, const Moment& now, std::vector<mqtt::Message>& out) {
  const Level level = task.next;
  const std::vector<soar::Member> members = {
      {"acknowledged_message_ID", base::JsonString(task.message_id)},
      {"status", base::JsonString(GetName(level))}};
  constexpr auto kType = MessageType::kAcknowledgement;
  Say(kType, task.reply_to, soar::BuildPayload(kType, members), now, out);
  if (!task.plan_id.empty() && level != Level::kC2Received) {
    const bool done = level == Level::kExecuted;
    state_ = done ? "IDLE" : "EXECUTING";
    platform_id_ = task.platform_id;
    plan_id_ = task.plan_id;
    if (done && task.last) place_ = *task.last;
    SayStatus(now, out);
  }
  if (level == Level::kExecuted || level == shared_.settings.stop_at) return false;
  task.next = static_cast<Level>(static_cast<int>(level) + 1);
  task.due += shared_.settings.delay;
  return true;
}

void VirtualPlatform::SayStatus(const Moment& now, std::vector<mqtt::Message>& out) {
  if (!self_.platform || shared_.settings.silent) return;
  next_status_ = now.steady + shared_.settings.status_interval;
  constexpr auto kType = MessageType::kPlatformStatus;
  const auto destination = soar::ParseDestination(self_.name, shared_.settings.prefix, kType);
  if (!destination) return;
  std::vector<soar::Member> members = {
      {"platform_ID", platform_id_},
      {"status_source", R"("onboard_platform")"},
      {"platform_timestamp", base::JsonString(base::FormatTimestamp(now.wall))},
      {"latitude", fmt::format("{}", place_.latitude)},
      {"longitude", fmt::format("{}", place_.longitude)},
      {"battery_remaining_capacity", fmt::format("{}", kBattery)},
      {"platform_state", base::JsonString(state_)}};
  if (!plan_id_.empty()) members.push_back({"autonomy_engine_plan_ID", plan_id_});
  Say(kType, *destination, soar::BuildPayload(kType, members), now, out);
}

void VirtualPlatform::Say(MessageType type, const soar::Destination& destination,
                          std::string_view payload, const Moment& now,
                          std::vector<mqtt::Message>& out) const {
  soar::Sender sender;
  sender.prefix = shared_.settings.prefix;
  sender.source = self_.name;
  const auto command = soar::BuildMessage(type, destination, sender, payload);
  out.push_back({command.topic, command.payload.Render(0, now.wall)});
}

steady_clock::time_point VirtualPlatform::Due() const {
  auto due = next_status_;
  for (const Task& task : tasks_) due = std::min(due, task.due);
  return due;
}

Result<std::unique_ptr<PlatformFleet>> PlatformFleet::Make(
    PlatformSettings settings, const std::vector<std::string>& destinations,
    schema::Registry& registry, EventCallback on_event) {
  const auto schema = registry.Find(soar::kMessageSchema);
  if (!schema) return Fail(schema.error());
  std::unique_ptr<PlatformFleet> fleet(new PlatformFleet(std::move(settings), std::move(on_event)));
  const soar::Prefix& prefix = fleet->settings_.prefix;
  for (const std::string& text : destinations) {
    auto self = soar::ParseDestination(text, prefix, MessageType::kMissionPlan);
    if (!self) return Fail(std::move(self.error()));
    const std::string filter =
        self->platform ? prefix.Topic(self->platform->Topic() + "/to_platform/+") : self->topic;
    if (!fleet->filters_.emplace(filter, fleet->platforms_.size()).second) {
      return Fail(ErrorKind::kUsage, fmt::format("{} is named twice", base::Printable(text)));
    }
    fleet->platforms_.emplace_back(VirtualPlatform::Shared{fleet->settings_, **schema},
                                   *std::move(self),
                                   static_cast<int>(fleet->platforms_.size() + 1));
  }
  return fleet;
}

std::vector<std::string> PlatformFleet::Subscriptions() const {
  std::vector<std::string> filters = {soar::Broadcast(settings_.prefix).topic};
  for (const auto& [filter, index] : filters_) filters.push_back(filter);
  return filters;
}

void PlatformFleet::Start(const Moment& now, std::vector<mqtt::Message>& out) {
  for (VirtualPlatform& platform : platforms_) platform.Start(now, out);
}

void PlatformFleet::Receive(const mqtt::Message& message, const Moment& now,
                            std::vector<mqtt::Message>& out) {
  const auto hand = [&](VirtualPlatform& platform) {
    platform.Receive(message, now, out,
                     [&](const Event& event) { on_event_(platform.self().name, event); });
  };
  if (message.topic == soar::Broadcast(settings_.prefix).topic) {
    for (VirtualPlatform& platform : platforms_) hand(platform);
    return;
  }
  for (const auto& [filter, index] : filters_) {
    if (delivery::Matches(filter, message.topic)) hand(platforms_[index]);
  }
}

void PlatformFleet::Tick(const Moment& now, std::vector<mqtt::Message>& out) {
  for (VirtualPlatform& platform : platforms_) platform.Tick(now, out);
}

steady_clock::time_point PlatformFleet::Due() const {
  auto due = steady_clock::time_point::max();
  for (const VirtualPlatform& platform : platforms_) due = std::min(due, platform.Due());
  return due;
}

}  // namespace fleetpub::simulator
