// How the states of a robot that drives are told in a few words.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "base/text.h"
#include "simulator/conversation.h"
#include "simulator/route.h"

namespace fleetpub::simulator {

constexpr auto kEdge = std::chrono::seconds(2);  // without positions

// What stands in a list of the newest state: `2 4h` are sequenceIds, `h` those of the horizon.
inline std::string Ahead(const Conversation& robot, const char* list) {
  std::string text;
  const auto state = robot.Last("state");
  for (const auto& leg : state[list].GetArray()) {
    if (!text.empty()) text += ' ';
    text += std::to_string(leg["sequenceId"].GetInt());
    if (!leg["released"].GetBool()) text += 'h';
  }
  return text;
}

// Those of the order: `a FINISHED, b WAITING`
inline std::string Actions(const base::JsonValue& state) {
  std::vector<std::string> texts;
  for (const auto& action : state["actionStates"].GetArray()) {
    const std::string id(base::StringMember(action, "actionId"));
    if (id.substr(0, 3) == "id-") continue;  // an instant one
    texts.push_back(id + ' ' + std::string(base::StringMember(action, "actionStatus")));
  }
  return base::Join(texts, ", ");
}
inline std::string Actions(const Conversation& robot) { return Actions(robot.Last("state")); }

// All states since the order: last node, what is ahead, whether it drives.
inline std::vector<std::string> Story(const Conversation& robot) {
  std::vector<std::string> story;
  for (const Utterance& one : robot.said()) {
    if (one.topic != "state") continue;
    const auto state = *base::ParseJson(one.payload);
    if (state["orderId"].GetStringLength() == 0) continue;
    story.push_back(fmt::format("{}:{} n{} e{} {}", state["lastNodeId"].GetString(),
                                state["lastNodeSequenceId"].GetInt(), state["nodeStates"].Size(),
                                state["edgeStates"].Size(),
                                state["driving"].GetBool() ? "drives" : "stands"));
  }
  return story;
}

class OrderRuns : public EachVersion {
 protected:
  void Order(Conversation& robot, const Route& route) const {
    robot.Hear("order", Write(route, GetParam()));
    EXPECT_EQ(robot.At("/errors"), "[]");
  }
  [[nodiscard]] const char* Position() const {
    return Is30() ? "/mobileRobotPosition" : "/agvPosition";
  }
  [[nodiscard]] double Number(const Conversation& robot, const std::string& name) const {
    const std::string text = robot.At((Position() + ("/" + name)).c_str());
    return text.empty() ? -99 : std::stod(text);
  }
};

// What an order's actions and driving look like, state by state.
inline std::vector<std::string> Queue(const Conversation& robot) {
  std::vector<std::string> story;
  for (const Utterance& one : robot.said()) {
    if (one.topic != "state") continue;
    const auto state = *base::ParseJson(one.payload);
    if (state["orderId"].GetStringLength() == 0) continue;
    story.push_back((state["driving"].GetBool() ? "drives: " : "stands: ") + Actions(state));
  }
  return story;
}

}  // namespace fleetpub::simulator
