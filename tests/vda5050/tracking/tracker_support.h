// What tests of trackers share: a robot that speaks in verbs.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/text.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::vda5050 {

inline constexpr std::string_view kId = "3f2c8a2e-7b51-4c4e-9d0a-5a4f0f6d1c22";
inline constexpr std::string_view kOther = "00000000-7b51-4c4e-9d0a-5a4f0f6d1c22";
inline constexpr bool kRetained = true;
inline constexpr std::uint32_t kHeaderId = 18;
inline const RobotAddress kRobot{"KIT", "0001"};

// `{"actionId":…,"actionStatus":…}`
inline std::string Entry(std::string_view id, std::string_view status, std::string_view more = "") {
  return fmt::format(R"({{"actionId":"{}","actionStatus":"{}"{}}})", id, status, more);
}

inline std::string Error(std::string_view type, std::string_view key, std::string_view value,
                         std::string_view more = "") {
  return fmt::format(R"({{"errorType":"{}","errorLevel":"WARNING","errorReferences":)"
                     R"([{{"referenceKey":"{}","referenceValue":"{}"}}]{}}})",
                     type, key, value, more);
}

// A conversation with one robot, told in verbs.
class ResponseTracker : public ::testing::Test {
 protected:
  void Follow(std::string_view type, WaitFor wait_for = WaitFor::kFinished,
              Version version = Version::k300, std::string_view id = kId) {
    const Dialect dialect{.version = version};
    prefix_ = version == Version::k300 ? "vda5050/v3/KIT/0001/" : "uagv/v2/KIT/0001/";
    const InstantAction action{std::string(type), std::string(id), "", "", parameters_};
    auto made = TrackInstantAction(kRobot, dialect, action, wait_for);
    if (!made) throw std::runtime_error(made.error().message);
    tracker_ = std::move(*made);
  }
  void Publish(std::uint32_t header_id = kHeaderId) { tracker_->Published(header_id); }
  void FollowAndPublish(std::string_view type, WaitFor wait_for = WaitFor::kFinished) {
    Follow(type, wait_for);
    Publish();
  }

  void Hear(std::string_view topic, std::string_view payload, bool retained = false) {
    tracker_->Receive(
        {.topic = prefix_ + std::string(topic), .payload = payload, .retained = retained});
  }
  void HearState(std::string_view members, bool retained = false) {
    Hear("state", fmt::format("{{{}}}", members), retained);
  }
  /// A state of 3.0 with these instantActionStates and errors.
  void HearActions(std::string_view entries, std::string_view errors = "", bool retained = false) {
    HearState(fmt::format(R"("instantActionStates":[{}],"actionStates":[],"errors":[{}])", entries,
                          errors),
              retained);
  }
  void HearErrors(std::string_view errors, bool retained = false) {
    HearActions("", errors, retained);
  }
  void HearConnection(std::string_view state, bool retained = false) {
    Hear("connection", fmt::format(R"({{"connectionState":"{}"}})", state), retained);
  }

  [[nodiscard]] const message::Progress& Now() const { return tracker_->progress(); }
  [[nodiscard]] bool HasEnded() const { return Now().ended; }
  [[nodiscard]] std::string Ending() const {
    return Now().ended ? std::string(message::GetName(Now().status)) : "WAITING";
  }
  [[nodiscard]] std::string Told() const { return Now().message; }

  /// What has been told before an end, one line behind the other.
  [[nodiscard]] std::string News() { return base::Join(tracker_->TakeNews(), "\n"); }

  std::vector<Parameter> parameters_;  ///< of the action
  std::string prefix_;
  std::unique_ptr<message::ResponseTracker> tracker_;
};

}  // namespace fleetpub::vda5050
