#include "delivery/recorded.h"

#include <utility>

#include "base/time.h"

namespace fleetpub::delivery {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::steady_clock;

recording::Moment MomentSince(steady_clock::time_point start) {
  return {.t = duration_cast<microseconds>(steady_clock::now() - start),
          .at = base::WallTime::clock::now()};
}

recording::Head MakeHead(std::string tool, const mqtt::ServerInfo& server,
                         std::vector<std::string> subscriptions, mqtt::Qos qos,
                         steady_clock::time_point start) {
  return {.tool = std::move(tool),
          .started = base::WallTime::clock::now(),
          .broker = server.broker.ToString(),
          .mqtt_version = server.version == mqtt::ProtocolVersion::k5 ? "5" : "3.1.1",
          .qos = static_cast<int>(qos),
          .subscriptions = std::move(subscriptions),
          .time_zero = duration_cast<microseconds>(start.time_since_epoch())};
}

recording::Message ToRecorded(const mqtt::Message& message, recording::Moment moment) {
  recording::Message entry;
  static_cast<recording::Moment&>(entry) = moment;
  entry.topic = message.topic;
  entry.payload = message.payload;
  entry.qos = static_cast<int>(message.qos);
  entry.retain = message.retained;
  entry.dup = message.duplicate;
  return entry;
}

Status Recorder::Begin(const std::filesystem::path& path, std::string tool,
                       const mqtt::ServerInfo& server, std::vector<std::string> subscriptions,
                       mqtt::Qos qos) {
  if (path.empty()) return {};
  auto opened = recording::Writer::Open(
      {.path = path,
       .rotation = {},
       .head = MakeHead(std::move(tool), server, std::move(subscriptions), qos, start_)});
  if (!opened) return Fail(std::move(opened.error()));
  writer_ = *std::move(opened);
  return {};
}

void Recorder::Add(const mqtt::Message& message) {
  if (writer_ == nullptr || !added_) return;
  added_ = writer_->Add(ToRecorded(message, MomentSince(start_)));
}

Status Recorder::End() {
  if (writer_ == nullptr) return {};
  const auto written = writer_->End();
  if (!written) return Fail(written.error());
  return added_;
}

}  // namespace fleetpub::delivery
