#include "app/explain_sources.h"

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "app/listen.h"
#include "base/text.h"
#include "delivery/recorded.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {
namespace {

// An entry, to whoever takes its kind; of messages those of the robot alone.
void HandOver(const recording::Entry& entry, const vda5050::RobotAddress& robot,
              const vda5050::TopicScheme& scheme, const MessageTakers& takers) {
  if (const auto* event = std::get_if<recording::Event>(&entry)) takers.event(*event);
  const auto* message = std::get_if<recording::Message>(&entry);
  if (message == nullptr) return;
  const auto levels = vda5050::ReadTopic(scheme, message->topic, robot.manufacturer);
  if (levels && levels->robot == robot) takers.message(*message, levels->topic_name);
}

class Ear final : public ListenObserver {
 public:
  Ear(std::chrono::steady_clock::time_point start, bool listens_on,
      std::vector<recording::Entry>& heard, std::vector<std::string>& brokers, Log& log)
      : start_(start), listens_on_(listens_on), heard_(heard), brokers_(brokers), log_(log) {}

  Status Begin(const mqtt::ServerInfo& server,
               const std::vector<std::string>& /*filters*/) override {
    brokers_ = server.ListSite();
    return {};
  }
  Status Take(const mqtt::Message& message, const vda5050::TopicLevels* levels) override {
    heard_.emplace_back(delivery::ToRecorded(message, delivery::MomentSince(start_)));
    const bool is_state = levels != nullptr && levels->topic_name == "state" && !message.retained;
    const bool is_connection = levels != nullptr && levels->topic_name == "connection";
    has_enough_ = has_enough_ || is_state || (is_connection && IsGone(message));
    return {};
  }
  void Lost(const Error& error) override {
    lost_at_ = delivery::MomentSince(start_);
    log_.Lost(error);
  }
  void ConnectedAgain() override {
    recording::Event gap;
    static_cast<recording::Moment&>(gap) = delivery::MomentSince(start_);
    gap.kind = "gap";
    gap.lasted = gap.t - lost_at_.t;
    heard_.emplace_back(std::move(gap));
    log_.ConnectedAgain();
  }
  Result<bool> GoesOn() override { return listens_on_ || !has_enough_; }

 private:
  // Then no state comes.
  static bool IsGone(const mqtt::Message& message) {
    const auto connection = vda5050::ReadConnection(message.payload);
    return connection && vda5050::IsAway(connection->connection_state);
  }

  std::chrono::steady_clock::time_point start_;
  bool listens_on_;
  std::vector<recording::Entry>& heard_;
  std::vector<std::string>& brokers_;
  Log& log_;
  recording::Moment lost_at_;
  bool has_enough_ = false;
};

}  // namespace

MessageSource FromRecording(std::filesystem::path file, vda5050::RobotAddress robot,
                            vda5050::TopicScheme scheme) {
  return [file = std::move(file), robot = std::move(robot),
          scheme = std::move(scheme)](const MessageTakers& takers) -> Result<recording::Faults> {
    auto reader = recording::Reader::Open(file);
    if (!reader) return Fail(std::move(reader.error()));
    while (true) {
      const auto entry = reader->Next();
      if (!entry) return Fail(entry.error());
      if (!*entry) return reader->faults();
      HandOver(**entry, robot, scheme, takers);
    }
  };
}

MessageSource FromEntries(std::vector<recording::Entry> entries, vda5050::RobotAddress robot,
                          vda5050::TopicScheme scheme) {
  return [entries = std::move(entries), robot = std::move(robot),
          scheme = std::move(scheme)](const MessageTakers& takers) -> Result<recording::Faults> {
    for (const recording::Entry& entry : entries) HandOver(entry, robot, scheme, takers);
    return recording::Faults();
  };
}

Status ListeningPost::Listen(const VdaOptions& vda, std::optional<std::chrono::milliseconds> listen,
                             const Environment& environment, Log& log) {
  began_ = delivery::MomentSince(start_);
  Ear ear(start_, listen.has_value(), heard_, brokers_, log);
  ListenRequest request{.targets = {}, .vda = vda, .topics = {}, .filters = {}};
  request.targets.words = {robot_.ToString()};
  request.topics = {"state", "connection", "order", "instantActions"};
  request.end = std::chrono::steady_clock::now() +
                listen.value_or(std::chrono::milliseconds(vda5050::kLongestSilence));
  log.Wait(fmt::format("listening to {}", base::Printable(robot_.ToString())), request.end);
  auto listened = app::Listen(std::move(request), environment, ear, log);
  log.Wait("");
  return listened;
}

recording::Event ListeningPost::Gap() const {
  recording::Event gap;
  static_cast<recording::Moment&>(gap) = began_;
  gap.kind = "gap";
  gap.text = "from here on is what the broker shows: nobody listened before";
  return gap;
}

recording::Moment ListeningPost::ToMoment(base::WallTime at) const {
  const auto now = delivery::MomentSince(start_);
  return {now.t - std::chrono::duration_cast<std::chrono::microseconds>(now.at - at), at};
}

}  // namespace fleetpub::app
