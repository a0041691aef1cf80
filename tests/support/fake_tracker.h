// Recognises a command's end without a robot.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "message/response_tracker.h"

namespace fleetpub::testing {

/// Awaits its topic for ever, or is finished once its command has left.
class FakeTracker final : public message::ResponseTracker {
 public:
  enum class Ends { kOncePublished, kNever };

  explicit FakeTracker(std::string topic, Ends ends = Ends::kOncePublished)
      : topic_(std::move(topic)), ends_(ends) {}

  [[nodiscard]] std::vector<std::string> Topics() const override { return {topic_}; }
  void Published(std::uint32_t /*header_id*/) override {
    if (ends_ == Ends::kNever) return;
    progress_ = {.seen = true, .ended = true, .status = message::CommandStatus::kFinished};
  }
  void Receive(const message::Incoming& /*message*/) override {}
  [[nodiscard]] const message::Progress& progress() const override { return progress_; }

 private:
  std::string topic_;
  Ends ends_;
  message::Progress progress_;
};

}  // namespace fleetpub::testing
