// Orders that a robot has, as the ledger and its state show them, and what may be added to them
// (VDA 5050 1.1–2.1 §6.6.4, 3.0 §6.1.2).
//
// An update begins with the decision point, the last node of the base, unchanged, and carries the
// whole horizon: what it leaves out is gone. Its orderUpdateId lies above every one that this ledger
// has recorded or the robot shows, so that none is used twice, whatever became of the message.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "ledger/ledger.h"
#include "vda5050/messages/order.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {

/// One order message, as the ledger has it.
struct SentOrder {
  std::int64_t row = 0;  ///< of the ledger
  std::uint32_t update_id = 0;
  std::string by;  ///< `ops@host`
  base::WallTime at;
  bool was_rejected = false;
  base::JsonDocument message;
};

/// All that the ledger has of one order, the newest message last.
struct OrderHistory {
  std::string order_id;
  std::vector<std::string> brokers;  ///< over which it was sent; none: any
  std::vector<SentOrder> sent;

  [[nodiscard]] std::uint32_t highest_update_id() const;
  /// The newest message of the update that the robot has, with the nodes that it shows: there may be
  /// another of the same id that it did not take. Null: none.
  [[nodiscard]] const SentOrder* Find(const vda5050::RobotState& state) const;
};

/// What was sent to this robot under this orderId, among its last orders. Errors: kLedger.
/// `brokers`: as ServerInfo::ListSite; none: any. Another site's robot of that name is another robot.
[[nodiscard]] Result<OrderHistory> ReadOrderHistory(ledger::Ledger& ledger,
                                                    std::vector<std::string> brokers,
                                                    const std::string& target,
                                                    std::string_view order_id);

/// Whether an order is under way, be it at the end of its base.
[[nodiscard]] bool IsUnderWay(const vda5050::RobotState& state);

/// What the robot drives, and where it may be continued.
class CurrentOrder {
 public:
  /// Errors: ErrorKind::kPreflight: the robot has no order, or one that this ledger does not know, or
  /// one that ended early. `name`: the robot's, for people.
  [[nodiscard]] static Result<CurrentOrder> Find(const OrderHistory& history,
                                                 const vda5050::RobotState& state,
                                                 std::string_view name);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::uint32_t next_update_id() const { return next_update_id_; }
  /// The last node of all, and its sequenceId.
  [[nodiscard]] std::string last_node() const;
  [[nodiscard]] std::uint32_t last_sequence_id() const;
  /// Nodes behind the decision point that are not released.
  [[nodiscard]] std::size_t horizon() const { return nodes_.size() - 1; }
  /// Their ids, in their order.
  [[nodiscard]] std::vector<std::string> horizon_nodes() const;

  /// Adds nodes and edges, which are JSON texts, behind the last one.
  void Append(std::vector<std::string> nodes, std::vector<std::string> edges);

  /// The update, with so many nodes behind the decision point released.
  [[nodiscard]] base::JsonDocument MakeUpdate(std::size_t released) const;

 private:
  std::string id_;
  std::string zone_set_id_;
  std::uint32_t next_update_id_ = 0;
  std::vector<std::string> nodes_;  // JSON: the decision point, then what lies behind it
  std::vector<std::string> edges_;
};

}  // namespace fleetpub::app
