// A received message, read and judged as a careful robot does.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rapidjson.h"
#include "schema/schema.h"
#include "simulator/action_handlers.h"
#include "simulator/settings.h"

namespace fleetpub::simulator {

struct ReceivedAction {
  ActionCall call;
  std::string descriptor;
  std::string fault;  ///< why it cannot be carried out; "" when it can
};

struct Inspection {
  base::JsonDocument message;
  std::string header_id;  ///< as text; "" when it cannot be read
  /// Why the whole message is refused; "" when it is not.
  std::string fault;
  /// Of an instantActions message or an order, as far as they can be read.
  std::vector<ReceivedAction> actions;

  /// `instantActions headerId 7`
  [[nodiscard]] std::string Place(std::string_view topic) const;
};

/// Those that are texts or numbers; of an array of texts, they are joined by commas.
[[nodiscard]] std::vector<Parameter> ReadParameters(const base::JsonValue& action);

/// Belongs to one thread.
class Inspector {
 public:
  /// Both outlive it.
  Inspector(const Settings& settings, schema::Registry& registry)
      : settings_(settings), registry_(registry) {}

  /// By schema and by the rules of the text.
  [[nodiscard]] Inspection InspectInstantActions(std::string_view payload);
  /// What is wrong with an action of an order is its own fault, not the message's.
  [[nodiscard]] Inspection InspectOrder(std::string_view payload);
  /// Any other message of fleet control's, likewise.
  [[nodiscard]] Inspection Inspect(std::string_view topic, std::string_view payload);

 private:
  [[nodiscard]] Inspection Open(std::string_view payload, std::string_view topic);

  const Settings& settings_;
  schema::Registry& registry_;
};

}  // namespace fleetpub::simulator
