// A virtual robot, someone who commands it, and a clock that only moves when told.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "simulator/factsheet.h"
#include "simulator/virtual_robot.h"
#include "vda5050/messages/instant_actions.h"

namespace fleetpub::simulator {

class Conversation {
 public:
  explicit Conversation(Settings settings)
      : settings_(std::move(settings)),
        inspector_(settings_, registry_),
        factsheet_(FactsheetBody(settings_)),
        robot_({settings_, GetTerms(settings_.version), inspector_, factsheet_},
               {std::string(vda5050::GetFacts(settings_.version).name), "KIT", "0001"}) {
    will_ = robot_.Will(now_).payload;
    robot_.Start(now_, said_);
  }

  /// Sends the action; parameters are `key`, JSON value. The actionId.
  std::string Do(std::string_view type, std::vector<vda5050::Parameter> parameters = {}) {
    const std::string id = "id-" + std::to_string(++count_);
    Do(id, type, std::move(parameters));
    return id;
  }
  void Do(const std::string& id, std::string_view type,
          std::vector<vda5050::Parameter> parameters) {
    const vda5050::InstantAction action{std::string(type), id, "", "", std::move(parameters)};
    const auto command =
        vda5050::BuildInstantActions({"KIT", "0001"}, {.version = settings_.version}, {&action, 1});
    ASSERT_TRUE(command);
    Hear("instantActions", command->payload.Render(7, now_.wall));
  }
  void Hear(std::string_view topic, std::string_view payload) {
    robot_.Receive(topic, payload, now_, said_,
                   [this](const Event& event) { remarks_.push_back(event); });
  }
  void Wait(std::chrono::milliseconds time) {
    now_.steady += time;
    now_.wall += time;
    if (robot_.Due() <= now_.steady) robot_.Tick(now_, said_);
  }
  /// The connection is lost for so long.
  void Reconnect(std::chrono::milliseconds after) {
    now_.steady += after;
    now_.wall += after;
    robot_.Start(now_, said_);
  }
  void End() { robot_.End(now_, said_); }

  [[nodiscard]] VirtualRobot& robot() { return robot_; }
  [[nodiscard]] const std::string& will() const { return will_; }
  [[nodiscard]] const std::vector<Event>& events() const { return remarks_; }

  /// Everything it has said so far.
  [[nodiscard]] const Utterances& said() const { return said_; }

  /// How often it has spoken on the topic.
  [[nodiscard]] std::size_t Times(std::string_view topic) const {
    std::size_t times = 0;
    for (const Utterance& one : said_) times += one.topic == topic ? 1U : 0U;
    return times;
  }
  /// The newest message of the topic; null when there is none.
  [[nodiscard]] base::JsonDocument Last(std::string_view topic) const {
    for (auto one = said_.rbegin(); one != said_.rend(); ++one) {
      if (one->topic == topic) return std::move(*base::ParseJson(one->payload));
    }
    return {};
  }
  /// Every connectionState so far, joined by a blank.
  [[nodiscard]] std::string Connections() const {
    std::string states;
    for (const Utterance& one : said_) {
      if (one.topic != "connection") continue;
      const auto message = base::ParseJson(one.payload);
      states += (states.empty() ? "" : " ");
      states += base::StringMember(*message, "connectionState");
    }
    return states;
  }
  /// What the newest state says at this JSON Pointer, as JSON; "" when there is nothing.
  [[nodiscard]] std::string At(const char* pointer) const {
    const base::JsonDocument state = Last("state");
    const base::JsonValue* value = base::JsonPointer(pointer).Get(state);
    return value == nullptr ? "" : base::ToJson(*value);
  }
  /// `FINISHED`, `FAILED: why`; "" when the newest state does not list the action.
  [[nodiscard]] std::string Of(const std::string& id) const {
    const base::JsonDocument state = Last("state");
    for (const char* list : {"actionStates", "instantActionStates"}) {
      if (!state.HasMember(list)) continue;
      for (const auto& action : state[list].GetArray()) {
        if (base::StringMember(action, "actionId") != id) continue;
        const auto& words = GetTerms(settings_.version);
        const std::string result(base::StringMember(action, words.action_result));
        return std::string(base::StringMember(action, "actionStatus")) +
               (result.empty() ? "" : ": " + result);
      }
    }
    return {};
  }

 private:
  Settings settings_;
  schema::Registry registry_;
  Inspector inspector_;
  std::string factsheet_;
  Moment now_{std::chrono::steady_clock::time_point(std::chrono::hours(1)),
              base::WallTime(std::chrono::hours(500'000))};
  VirtualRobot robot_;
  std::string will_;
  Utterances said_;
  std::vector<Event> remarks_;
  int count_ = 0;
};

/// A test for each version.
class EachVersion : public ::testing::TestWithParam<vda5050::Version> {
 protected:
  [[nodiscard]] Settings Plain() const { return {.version = GetParam()}; }
  [[nodiscard]] const ProtocolTerms& words() const { return GetTerms(GetParam()); }
  [[nodiscard]] bool Is30() const { return GetParam() == vda5050::Version::k300; }
};

inline std::string VersionName(const ::testing::TestParamInfo<vda5050::Version>& info) {
  std::string name = "V";
  for (const char c : vda5050::GetFacts(info.param).name) {
    if (c != '.') name += c;
  }
  return name;
}

}  // namespace fleetpub::simulator
