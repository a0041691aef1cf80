// What a broker says, as a recording has it.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"
#include "recording/entry.h"
#include "recording/writer.h"

namespace fleetpub::delivery {

/// Now, in a recording that began then.
[[nodiscard]] recording::Moment MomentSince(std::chrono::steady_clock::time_point start);

/// The first line of a recording that begins `start`: from this broker, by these subscriptions.
[[nodiscard]] recording::Head MakeHead(std::string tool, const mqtt::ServerInfo& server,
                                       std::vector<std::string> subscriptions, mqtt::Qos qos,
                                       std::chrono::steady_clock::time_point start);

/// A message that came then.
[[nodiscard]] recording::Message ToRecorded(const mqtt::Message& message, recording::Moment moment);

/// Records what is heard beside other work.
class Recorder {
 public:
  /// Into no file when the path is empty. Errors: ErrorKind::kLedger.
  [[nodiscard]] Status Begin(const std::filesystem::path& path, std::string tool,
                             const mqtt::ServerInfo& server, std::vector<std::string> subscriptions,
                             mqtt::Qos qos);
  void Add(const mqtt::Message& message);
  /// Errors: ErrorKind::kLedger: something could not be written.
  [[nodiscard]] Status End();

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::unique_ptr<recording::Writer> writer_;  // null: no file
  Status added_;
};

}  // namespace fleetpub::delivery
