// How far a robot has come with an order, as its states show it one after the other.
//
// An order is done when its last node was reached and each of its actions was seen to its end. That
// an order of this id is shown as done proves neither: the robot may have had it before. So it must
// have been shown as not done, or have appeared after a state that did not show it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rapidjson.h"
#include "message/response_tracker.h"
#include "vda5050/reports/robot_messages.h"
#include "vda5050/tracking/action_tracker.h"

namespace fleetpub::vda5050 {

class OrderProgress {
 public:
  OrderProgress(const base::JsonValue& order, WaitFor wait_for);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::uint32_t update_id() const { return update_id_; }
  /// Its actions, nodes and edges, as an error would name them.
  [[nodiscard]] const std::vector<ErrorReference>& parts() const { return parts_; }

  /// The robot is known to have taken this very order: that it shows it as done is its end.
  void AssumeTaken() { is_taken_ = was_open_ = true; }

  /// A live state that came before the order was published.
  void Before(const RobotState& state);

  /// What a later state says of the order; nothing while none has shown it.
  [[nodiscard]] std::optional<message::Progress> Look(const RobotState& state);

  /// The actions that have failed, or wait for retry or skipRetry, since the last call, in words.
  [[nodiscard]] std::vector<std::string> TakeNews() { return std::exchange(news_, {}); }
  /// `n4 (2 of 5)  driving`, when that has changed since the last call; else "".
  [[nodiscard]] std::string TakePlace() { return std::exchange(place_news_, {}); }

 private:
  struct Action {
    std::string id;
    std::string type;
    std::string status = {};  ///< the last one listed; "": never
    std::string result = {};
    std::string other_type = {};  ///< as which it was listed instead
  };

  void AddLeg(const base::JsonValue& leg, std::string_view id_key);
  void Record(const RobotState& state);
  void AddNews(const Action& action);
  void AddPlace(const RobotState& state);
  [[nodiscard]] bool IsAtLastNode(const RobotState& state) const;
  [[nodiscard]] bool IsNew(const RobotState& state) const;
  [[nodiscard]] message::Progress Conclude(const RobotState& state, bool is_shown);
  [[nodiscard]] std::string ActionText() const;
  [[nodiscard]] std::string PlaceText(const RobotState& state) const;

  std::string id_;
  std::uint32_t update_id_ = 0;
  WaitFor wait_for_;
  std::vector<Action> actions_;
  std::vector<ErrorReference> parts_;
  std::string last_node_;
  std::uint32_t last_sequence_id_ = 0;
  bool is_one_place_ = false;  ///< one node, and nothing to do there
  bool last_node_occurs_twice_ = false;

  bool had_it_before_ = false;
  /// Where the robot stood when a state last did not show the order, and that one did not.
  std::optional<std::string> place_without_;
  bool is_taken_ = false;
  bool was_open_ = false;       ///< since then a state showed it as not done
  bool was_under_way_ = false;  ///< with nodes, edges or actions to go
  bool keeps_sequence_ids_ = false;
  bool is_reached_ = false;
  std::vector<std::string> news_;
  std::string place_;  ///< told last
  std::string place_news_;
};

}  // namespace fleetpub::vda5050
