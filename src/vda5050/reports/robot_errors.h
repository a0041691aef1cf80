// Whose an error in a robot's state is. Robots name the action or the order that an error is about
// under several keys, some by the message's header id alone, some not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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
[[nodiscard]] Attribution AttributionOf(const RobotError& error, const SentItem& item);

/// `noOrderToCancel: there is no order; hint: send one`, printable and short.
[[nodiscard]] std::string Told(const RobotError& error);

/// The errors that came with, and after, what was sent and are, or may be, about it.
class RelatedErrors {
 public:
  /// What stood there before is about something else. A retained state does not tell all of it.
  void Remember(const std::vector<RobotError>& errors, bool retained);

  /// Of the new errors of one state, the nearest to being ours.
  [[nodiscard]] Attribution Note(const std::vector<RobotError>& errors, const SentItem& item);

  /// Whether one of them names what was sent, be it by its header id.
  [[nodiscard]] bool AreOurs() const { return !item_.empty() || !header_id_.empty(); }

  /// The nearest ones in words; "" when there are none.
  [[nodiscard]] std::string Text() const;

 private:
  std::vector<std::size_t> old_;  ///< fingerprints
  bool knows_before_ = false;
  bool id_is_fresh_ = false;       ///< no error from before can name it
  std::vector<std::string> item_;  ///< told
  std::vector<std::string> header_id_;
  std::vector<std::string> unnamed_;
};

}  // namespace fleetpub::vda5050
