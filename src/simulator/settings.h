// How virtual robots are to behave, faults included.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "simulator/faults.h"
#include "simulator/robot_state.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/version.h"

namespace fleetpub::simulator {

/// What an action of an order takes unless somebody says otherwise.
constexpr std::chrono::milliseconds kActionTime{200};

/// How an instant action is refused. Both are found in the field.
enum class RejectStyle {
  kAsTheVersionSays,  ///< up to 2.1 kError, from 3.0 kState
  kState,             ///< an action state FAILED and an error
  kError,             ///< an error alone
};

/// Somebody turns the key.
struct ModeChange {
  std::chrono::milliseconds after{0};  ///< the start
  std::string mode;
};

struct Settings {
  vda5050::Version version = vda5050::Version::k300;
  vda5050::TopicScheme topics;
  std::string actions_key;  ///< `actions` or `instantActions`; empty: the version's own
  std::chrono::milliseconds state_interval{30'000};
  std::string operating_mode = "AUTOMATIC";
  bool with_order = false;
  /// So many ended instant actions fit (3.0); more are refused until clearInstantActions. 0: the
  /// oldest ones go.
  std::size_t list_limit = 0;
  RobotState initial;  ///< how they begin, but for mode and order

  // Driving.
  double speed = 1;                            ///< m/s, at most
  double time_scale = 1;                       ///< so many times as fast: driving, actions, battery
  std::chrono::milliseconds edge_time{2'000};  ///< along an edge of unknown length
  /// The edges of an order take so long together, however long they are. Zero: as speed says.
  std::chrono::milliseconds order_time{0};
  std::chrono::milliseconds min_state_interval{0};      ///< between two states
  std::chrono::milliseconds visualization_interval{0};  ///< zero: none
  std::size_t order_limit = 0;                          ///< nodes in an order; 0: any number
  std::set<std::string, std::less<>> unreachable;       ///< nodes that no way leads to
  std::vector<ModeChange> mode_changes;

  /// Faults. Action types are the version's own names.
  std::optional<std::chrono::milliseconds> delay;  ///< none: at once; in an order, kActionTime
  std::set<std::string, std::less<>> fail;
  std::set<std::string, std::less<>> reject;
  std::set<std::string, std::less<>> retriable;
  std::set<std::string, std::less<>> hang;  ///< an order's actions that never end
  RejectStyle reject_style = RejectStyle::kAsTheVersionSays;
  Faults faults;
  bool silent = false;     ///< never publishes a state
  double drop = 0;         ///< share of the received messages that is ignored, 0 to 1
  unsigned drop_seed = 1;  ///< the same seed drops the same messages

  [[nodiscard]] bool Has(Fault fault) const { return faults.Has(fault); }
  [[nodiscard]] std::chrono::milliseconds Delay() const {
    return Scaled(delay.value_or(std::chrono::milliseconds(0)));
  }
  [[nodiscard]] std::chrono::milliseconds ActionTime() const {
    return Scaled(delay.value_or(kActionTime));
  }
  [[nodiscard]] std::chrono::milliseconds Scaled(std::chrono::milliseconds time) const {
    return std::chrono::duration_cast<std::chrono::milliseconds>(time / time_scale);
  }
  [[nodiscard]] RejectStyle Style() const {
    if (reject_style != RejectStyle::kAsTheVersionSays) return reject_style;
    return version >= vda5050::Version::k300 ? RejectStyle::kState : RejectStyle::kError;
  }
};

}  // namespace fleetpub::simulator
