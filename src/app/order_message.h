// Orders that are made from words, a layout and what the robot says of itself: new ones, and updates
// of the one that it has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "app/environment.h"
#include "app/order_path.h"
#include "app/robot_messages.h"
#include "base/result.h"
#include "layout/layout.h"

namespace fleetpub::app {

enum class OrderKind {
  kNew,      ///< an order of its own
  kExtend,   ///< more nodes behind the last one
  kRelease,  ///< nodes of the horizon become part of the base
};

/// What somebody wants a robot to drive.
struct OrderTask {
  OrderKind kind = OrderKind::kNew;
  PathRequest path;                          ///< kNew, kExtend
  std::shared_ptr<const layout::Site> site;  ///< may be null
  std::string order_id;                      ///< kNew; "": a random one
  /// kNew: so many nodes are released, the first among them; else so many of those behind the base.
  /// Nothing: all, but that kExtend leaves a horizon one.
  std::optional<std::size_t> release;
  std::set<std::string> without;  ///< members that are left out: `maxSpeed`
  bool check = true;              ///< refuse what the robot's state, mode and factsheet are against
  bool is_online = true;          ///< the robot's state was asked for
  /// kNew: what it drives is cancelled before. It may be under way yet, and elsewhere by then.
  bool replaces = false;
};

/// The robot as it is known when the order is made. `state`: live; null: none came.
struct OrderRobot {
  const vda5050::RobotAddress& address;
  const vda5050::Dialect& dialect;
  const vda5050::Factsheet* factsheet = nullptr;
  const vda5050::RobotState* state = nullptr;
  /// At which it is, as ServerInfo::ListSite; none: not asked.
  std::vector<std::string> brokers = {};
};

struct ComposedOrder {
  base::JsonDocument message;  ///< without header
  /// See message::Command: of an order that is made of what was sent before.
  std::optional<std::uint32_t> expected_header_id;
  std::vector<std::string> notes;  ///< for people, one line each
};

/// Errors: ErrorKind::kUsage (a place, an action), kPreflight (another order is active, the robot is
/// elsewhere, no route, not supported), kLedger. `ledger` is opened for reading when it is needed.
[[nodiscard]] Result<ComposedOrder> ComposeOrder(const OrderTask& task, const OrderRobot& robot,
                                                 const LedgerHook& ledger);

/// The order as a command. Errors: as vda5050::BuildUserMessage's.
[[nodiscard]] Result<message::Command> BuildOrder(const ComposedOrder& order,
                                                  const vda5050::RobotAddress& robot,
                                                  const vda5050::Dialect& dialect,
                                                  std::optional<std::uint32_t> header_id = {});

/// Composes for whichever robot it is prepared for. The task and the hook are shared.
[[nodiscard]] std::unique_ptr<RobotMessage> MakeOrderMessage(std::shared_ptr<const OrderTask> task,
                                                             LedgerHook ledger);

}  // namespace fleetpub::app
