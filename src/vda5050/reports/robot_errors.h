// Whose an error in a robot's state is. Robots name the action or the order that an error is about
// under several keys, some by the message's header id alone, some not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// In rising order of how near it is.
enum class Attribution {
  kOther,     ///< about something else
  kUnnamed,   ///< names nobody
  kHeaderId,  ///< names our header id and topic: probably ours, ids of two senders can meet
  kPart,      ///< names an action, node or edge of our order
  kItem,      ///< a reference's value is our id
};

/// What was sent, as an error would name it.
struct SentItem {
  std::string_view topic;   ///< `instantActions`
  std::string_view id_key;  ///< `actionId`, `orderId`, `zoneSetId`, `requestId`
  std::string_view id;
  std::span<const std::uint32_t> header_ids;    ///< of each time it was sent
  std::optional<std::uint32_t> update_id = {};  ///< `orderUpdateId`, of an order
  std::span<const ErrorReference> parts = {};   ///< `actionId`, `nodeId`, `edgeId` of an order
};

/// Never by the type alone: NO_ORDER_TO_CANCEL of an earlier attempt stays until the next order.
/// A short id (`1`) is no match under a key that names another thing (`headerId`). What an error
/// names beside our order, such as the order and the update that the robot has, does not make it
/// another's.
[[nodiscard]] Attribution Attribute(const RobotError& error, const SentItem& item);

/// Whether it says that there is no order to cancel, by its type.
[[nodiscard]] bool IsNoOrder(const RobotError& error);

/// Whether the robot says that it can keep no further ended instant actions until
/// clearInstantActions (3.0).
[[nodiscard]] bool IsInstantActionListFull(const std::vector<RobotError>& errors);

/// The highest header id of a message on this topic that an error names.
[[nodiscard]] std::optional<std::uint32_t> HighestHeaderId(const std::vector<RobotError>& errors,
                                                           std::string_view topic);

/// `noOrderToCancel: there is no order; hint: send one`, printable and short.
[[nodiscard]] std::string FormatError(const RobotError& error);

/// The errors that came with, and after, what was sent and are, or may be, about it.
class RelatedErrors {
 public:
  /// What stood there before is about something else. A retained state does not tell all of it.
  void Remember(const std::vector<RobotError>& errors, bool retained);

  /// Of the new errors of one state, the nearest to being ours.
  [[nodiscard]] Attribution Add(const std::vector<RobotError>& errors, const SentItem& item);

  /// Whether one of them names what was sent, be it by its header id.
  [[nodiscard]] bool AreOurs() const { return !item_.empty() || !header_id_.empty(); }

  /// Whether a new one says that there is no order to cancel, and may be ours.
  [[nodiscard]] bool SayNoOrder() const { return say_no_order_; }

  /// New ones that keep a robot from going on, in words; each once, a few in all.
  [[nodiscard]] std::vector<std::string> TakeSevere() { return std::exchange(severe_, {}); }

  /// The nearest ones in words; "" when there are none.
  [[nodiscard]] std::string Text() const;

 private:
  std::vector<std::size_t> old_;  ///< fingerprints
  bool knows_before_ = false;
  bool id_is_fresh_ = false;       ///< no error from before can name it
  std::vector<std::string> item_;  ///< told
  std::vector<std::string> header_id_;
  std::vector<std::string> unnamed_;
  bool say_no_order_ = false;
  std::set<std::size_t> told_;  ///< fingerprints of severe ones
  std::vector<std::string> severe_;
};

}  // namespace fleetpub::vda5050
