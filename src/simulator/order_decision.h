// Whether a virtual robot takes an order: the figure on order updates of every version (Figure 8,
// 1.1–2.1 §6.6.4, 3.0 §6.1.4), question by question, and how a refusal is reported (3.0 §6.6.5.4).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "simulator/inspection.h"
#include "simulator/order_plan.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"
#include "simulator/settings.h"

namespace fleetpub::simulator {

enum class Outcome {
  kNew,      ///< a new order: everything of the old one goes
  kUpdate,   ///< the horizon goes, the rest is joined to the base
  kReplace,  ///< 1.1: an update under another orderId
  kDiscard,  ///< is there already; nothing changes
  kRefuse,
};

struct Decision {
  Outcome outcome = Outcome::kRefuse;
  RobotError error = {};  ///< of kRefuse
};

/// What the decision is made from.
struct Asked {
  const Inspection& inspection;  ///< of a message that is no `fault`
  const OrderPlan& plan;
  const RobotState& state;
  const Settings& settings;
  const ProtocolTerms& terms;
  bool is_same_content;  ///< as the message that was accepted last, but for its header
  bool is_cancelling;    ///< a cancelOrder runs
};

[[nodiscard]] Decision Decide(const Asked& asked);

/// Of a message that breaks schema or text.
[[nodiscard]] RobotError RefuseMalformed(const Inspection& inspection, const Settings& settings);

}  // namespace fleetpub::simulator
