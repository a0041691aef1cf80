// A fleet as its robots' connection and state messages show it, one message after the other.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "vda5050/model/robot_pattern.h"
#include "vda5050/reports/discovery.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// What is known of one robot. Texts are the robot's own and untrusted.
struct RobotView {
  RobotAddress robot;
  std::string interface_name;        ///< first topic level; "" when the template has none
  std::string topic_level;           ///< `v3`; "" when the template has none
  std::optional<Version> version;    ///< in which it is spoken to; nothing: in none of ours
  std::string header_version;        ///< as it writes it
  std::string connection_state;      ///< normalised; "": not known
  std::string connection_timestamp;  ///< as written; "": not known
  std::string connection_fault;      ///< why its connection message cannot be read; "": it can
  std::string place;                 ///< TopicLevels::Place, of which all this is
  std::string also_at;               ///< another place, at which it is ONLINE or speaks, too
  /// The last live one that came, without its actions, zone sets and position.
  std::optional<RobotState> state;
  /// Of `state`, when it had more than could be kept (FleetView::abridged): errors beyond the one
  /// that weighs most.
  std::size_t errors_left_out = 0;
  std::string state_fault;  ///< why the last one that came could not be read; "": it could

  [[nodiscard]] bool IsOnline() const { return connection_state == "ONLINE"; }
  [[nodiscard]] bool HasSpoken() const { return state || !state_fault.empty(); }
};

/// Whether the broker had stored a message before we subscribed.
enum class Origin { kLive, kRetained };

class FleetView {
 public:
  /// Of the robots that a pattern means; without any, of all.
  FleetView(TopicScheme scheme, std::vector<RobotPattern> patterns);

  /// What to subscribe to. Errors: ErrorKind::kUsage (the scheme's template).
  [[nodiscard]] Result<std::vector<std::string>> Filters() const;

  /// Takes a message in. The robot that it is about; null when it tells nothing of any robot that
  /// the patterns mean. A robot with several connection messages (two versions, or an old one left
  /// behind) is seen where it speaks, else as OnePerRobot decides. A retained state is the past: it
  /// tells that there is a robot, not how it is. Lives until the next call.
  const RobotView* Deliver(std::string_view topic, std::string_view payload, Origin origin);

  /// Robots whose last state says more than could be kept: 20 MiB for all of them together. Of such
  /// a state its worst error is left, texts are cut with `…`, and requests are not there.
  [[nodiscard]] std::size_t abridged() const { return abridged_; }

  [[nodiscard]] bool IsMeant(const RobotAddress& robot) const;
  [[nodiscard]] const TopicScheme& scheme() const { return base_.topics; }
  [[nodiscard]] bool Knows(const RobotAddress& robot) const { return robots_.contains(robot); }
  [[nodiscard]] std::size_t size() const { return robots_.size(); }
  /// In order of address. They live until the next Deliver().
  [[nodiscard]] std::vector<const RobotView*> robots() const;

 private:
  struct Entry {
    std::map<std::string, Discovered, std::less<>> connections;  ///< by topic
    RobotView view;
    std::string live_place;       ///< at which it speaks; "": at none
    bool has_begun_anew = false;  ///< its next state may count and date anew
    std::size_t kept = 0;         ///< bytes of what the state says at any length
    bool is_abridged = false;
  };

  bool TakeConnection(Entry& entry, std::string_view topic, std::string_view payload,
                      Origin origin);
  bool TakeState(Entry& entry, std::string_view topic, const TopicLevels& levels,
                 std::string_view payload, Origin origin);
  void Choose(Entry& entry, const std::optional<Discovered>& speaker);
  void DropState(Entry& entry);
  void Keep(Entry& entry, RobotState state);
  void Describe(RobotView& view, const Discovered& found) const;

  Dialect base_;
  std::vector<RobotPattern> patterns_;
  std::map<RobotAddress, Entry> robots_;
  std::size_t kept_ = 0;
  std::size_t abridged_ = 0;
  std::map<RobotAddress, std::string> faults_;  ///< of states of robots that nothing is known of
};

/// The entry whose level weighs most (FATAL, CRITICAL, URGENT, WARNING, others), or null.
[[nodiscard]] const RobotError* WorstError(const std::vector<RobotError>& errors);

}  // namespace fleetpub::vda5050
