// How virtual robots are to behave, faults included.
#pragma once

#include <chrono>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "simulator/robot_state.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/version.h"

namespace fleetpub::simulator {

/// How an instant action is refused. Both are found in the field.
enum class RejectStyle {
  kAsTheVersionSays,  ///< up to 2.1 kError, from 3.0 kState
  kState,             ///< an action state FAILED and an error
  kError,             ///< an error alone
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
  /// After how long an order is done; zero: when it is cancelled.
  std::chrono::milliseconds order_time{0};

  RobotState initial;  ///< how they begin, but for mode and order

  /// Faults. Action types are the version's own names.
  std::chrono::milliseconds delay{0};
  std::set<std::string, std::less<>> fail;
  std::set<std::string, std::less<>> reject;
  std::set<std::string, std::less<>> retriable;
  RejectStyle reject_style = RejectStyle::kAsTheVersionSays;
  bool silent = false;     ///< never publishes a state
  double drop = 0;         ///< share of the received messages that is ignored, 0 to 1
  unsigned drop_seed = 1;  ///< the same seed drops the same messages

  [[nodiscard]] RejectStyle Style() const {
    if (reject_style != RejectStyle::kAsTheVersionSays) return reject_style;
    return version >= vda5050::Version::k300 ? RejectStyle::kState : RejectStyle::kError;
  }
};

}  // namespace fleetpub::simulator
