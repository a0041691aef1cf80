// Whose an error in a robot's state is. Robots name the action or the order that an error is about
// under several keys, some by the message's header id alone, some not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

enum class Attribution {
  kOther,     ///< about something else
  kItem,      ///< a reference's value is our id
  kHeaderId,  ///< names our header id and topic: probably ours, ids of two senders can meet
  kUnnamed,   ///< names nobody
};

/// What was sent, as an error would name it.
struct SentItem {
  std::string_view topic;   ///< `instantActions`
  std::string_view id_key;  ///< `actionId`, `orderId`, `zoneSetId`, `requestId`
  std::string_view id;
  std::span<const std::uint32_t> header_ids;    ///< of each time it was sent
  std::optional<std::uint32_t> update_id = {};  ///< `orderUpdateId`, of an order
};

/// Never by the type alone: NO_ORDER_TO_CANCEL of an earlier attempt stays until the next order.
/// A short id (`1`) is no match under a key that names another thing (`headerId`).
[[nodiscard]] Attribution AttributionOf(const RobotError& error, const SentItem& item);

/// The same for the same error in a later state.
[[nodiscard]] std::size_t FingerprintOf(const RobotError& error);

/// `noOrderToCancel: there is no order; hint: send one`, printable and short.
[[nodiscard]] std::string Told(const RobotError& error);

}  // namespace fleetpub::vda5050
