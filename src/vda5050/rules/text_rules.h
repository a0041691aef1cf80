// The rules that stand in the specification's text and not in its schemas.
#pragma once

#include <string_view>
#include <vector>

#include "base/time.h"
#include "message/command.h"
#include "vda5050/model/version.h"

namespace fleetpub::vda5050 {

/// Checks an instantActions message that already satisfies its schema: at least one action, no
/// actionId twice, each action one that this version allows as an instant action, its parameters of
/// the table's types and complete, theta within ±π. Warned about: keys and action types that nearly
/// are predefined ones, parameters that another version predefines, characters that the
/// specification does not recommend for ids (§6.1).
[[nodiscard]] std::vector<message::TextFinding> CheckInstantActions(const base::JsonValue& message,
                                                                    Version version);

/// Checks an order that already satisfies its schema: nodes and edges alternate, one edge fewer
/// than nodes, sequenceIds continuous over both, each edge between its neighbours, a base that
/// begins with a released node, ends with one and lies before the horizon (§6.6), actionIds unique,
/// each predefined action where its table allows it, with its parameters. Characters of ids as
/// above.
[[nodiscard]] std::vector<message::TextFinding> CheckOrder(const base::JsonValue& message,
                                                           Version version);

/// Checks a zoneSet (3.0 §6.4): zoneIds unique, polygons with three different vertices or more,
/// actionIds unique. Characters of ids as above.
[[nodiscard]] std::vector<message::TextFinding> CheckZoneSet(const base::JsonValue& message);

/// Checks responses (3.0 §6.4.3): at least one, no request twice, leaseExpiry only with GRANTED, as
/// a time and in the future of `now`.
[[nodiscard]] std::vector<message::TextFinding> CheckResponses(const base::JsonValue& message,
                                                               base::WallTime now);

/// The rules for a topic; empty for one that fleet control does not publish.
[[nodiscard]] message::TextRules TextRulesFor(std::string_view topic, Version version);

}  // namespace fleetpub::vda5050
