// What each predefined instant action does to a virtual robot.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"

namespace fleetpub::simulator {

/// An action that is to be carried out.
struct ActionCall {
  std::string id;
  std::string type;
  std::vector<Parameter> parameters;

  /// The parameter's text; "" when there is none.
  [[nodiscard]] std::string Text(std::string_view key) const;
  [[nodiscard]] double Number(std::string_view key) const;
};

/// What happens beside a change of the state.
enum class SideEffect {
  kNone,
  kFactsheet,
  kHibernate,
  kWake,
  kShutDown,
  kRetry,
  kSkipRetry,
  kCancel
};

struct ActionResult {
  bool finished = true;  ///< else FAILED
  std::string result = {};
  std::optional<RobotError> error = {};
  SideEffect side_effect = SideEffect::kNone;
  std::string target = {};  ///< of kRetry and kSkipRetry: an action's id
};

/// How an action begins when it takes its time (1.1–2.1 §6.8.2, 3.0 §6.2.5).
enum class Beginning { kWaiting, kInitializing, kRunning };

[[nodiscard]] Beginning FindBeginning(std::string_view type);

/// Whether an action of an order can be paused and given up once it is under way. A load that is
/// half on a fork cannot.
[[nodiscard]] bool IsInterruptible(std::string_view type);

/// Carries it out. An action without an entry in the table finishes and changes nothing.
[[nodiscard]] ActionResult Execute(const ActionCall& call, RobotState& state,
                                   const ProtocolTerms& terms);

}  // namespace fleetpub::simulator
