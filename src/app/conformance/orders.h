// Orders for the cases: where the robot stands, and along its way.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "app/conformance/run.h"

namespace fleetpub::app::conformance {

/// One order message.
struct TestOrder {
  std::string id;
  std::uint32_t update_id = 0;
  vda5050::OrderPath path;
  std::size_t released = SIZE_MAX;  ///< so many nodes
  std::uint32_t first_sequence_id = 0;

  [[nodiscard]] std::uint32_t LastSequenceId() const {
    return first_sequence_id + 2 * static_cast<std::uint32_t>(path.nodes.size() - 1);
  }
};
[[nodiscard]] base::JsonDocument Write(const Run& run, const TestOrder& order);

/// Whether its factsheet lets orders have it: `order.edges.maxSpeed`.
[[nodiscard]] bool Takes(const Run& run, std::string_view member);

/// A node at the place where the robot is.
[[nodiscard]] vda5050::OrderNode Here(const Run& run, std::string id = "conform-here");
/// An edge from node to node, of which nothing else is said.
[[nodiscard]] vda5050::OrderEdge Edge(std::string id);
/// Has an order that begins with this node begin where the robot stands, however far that is.
void Reach(const Run& run, vda5050::OrderNode& node);
/// For that one node alone.
[[nodiscard]] TestOrder Standing(Run& run);
/// That node, and another at the same place that is not released: the robot keeps it, and stands.
[[nodiscard]] TestOrder Holding(Run& run, const std::string& next = "conform-next");

/// Run::Once<bool>: whether it has taken up a load and not put it down.
inline constexpr const char* kLoaded = "carries a load of ours";

/// A harmless action that the robot knows for this scope; "" as its type: none.
[[nodiscard]] vda5050::InstantAction HarmlessAction(Run& run, std::string_view scope,
                                                    std::string_view blocking_type);

[[nodiscard]] bool HasOrder(const vda5050::RobotState& state, const TestOrder& order);
[[nodiscard]] bool IsIdle(const vda5050::RobotState& state);
/// What a robot that takes nothing is asked again: whether it takes an order of one node, anew.
[[nodiscard]] bool TakeStanding(Run& run);
/// Sends an order and waits until a state shows it.
[[nodiscard]] Awaited SendAndAwait(Run& run, const TestOrder& order);
/// Holds an order with a horizon (Holding), and tells whether it does.
[[nodiscard]] bool Hold(Run& run, const TestOrder& order);
inline constexpr const char* kNoHorizon = "it does not keep an order with a horizon";
/// A robot that cancels ends it within this time.
inline constexpr std::chrono::seconds kCancel{120};
/// Has it give up what it has, and waits until it is idle.
void EndOrder(Run& run);

/// Of 1.1 and 2.0, of 2.1, from 3.0; "": the text names none.
struct ErrorTypes {
  std::string_view up_to_20;
  std::string_view in_21;
  std::string_view from_30;
};
/// Sends what must be refused, and leaves nothing behind. `error`: what it was refused with.
[[nodiscard]] CaseFinding CheckRefusal(Run& run, const base::JsonDocument& order,
                                       const ErrorTypes& types,
                                       vda5050::RobotError* error = nullptr);

// ---- Driving ----

/// One drive along the way, there or back.
struct Trip {
  TestOrder order;
  std::size_t mark = 0;  ///< in Run::heard()
  Awaited end;
  std::string refusal;  ///< why it was not driven; "": it was
};
/// A new order along the way, from where it stands; without nodes when there is no way.
[[nodiscard]] TestOrder AlongWay(Run& run);
/// Until its last node; a robot that does not come there is called off.
[[nodiscard]] Trip Drive(Run& run, TestOrder order);
/// Sends an order, waits until it drives.
[[nodiscard]] Awaited SetOff(Run& run, const TestOrder& order);

/// Why nothing can be said of the trip; "": it came to its end.
[[nodiscard]] std::string Unfinished(const Trip& trip);

}  // namespace fleetpub::app::conformance
