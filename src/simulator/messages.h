// Writes the messages of a virtual robot.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/time.h"
#include "simulator/faults.h"
#include "simulator/protocol_terms.h"
#include "simulator/robot_state.h"

namespace fleetpub::simulator {

/// The first members of every message; the same for all of a robot's messages but for id and time.
struct Header {
  std::string version;
  std::string manufacturer;
  std::string serial_number;
  bool has_zone = true;  ///< the timestamp ends with Z
};

/// A message with this header; `body` is the rest of its members, as JSON without braces.
[[nodiscard]] std::string Message(const Header& header, std::uint32_t header_id,
                                  base::WallTime time, std::string_view body);

[[nodiscard]] std::string ConnectionBody(std::string_view connection_state);
[[nodiscard]] std::string StateBody(const RobotState& state, const ProtocolTerms& terms,
                                    const Faults& faults = {});
/// `state_header_id`: of the state that it goes with, from 3.0.
[[nodiscard]] std::string VisualizationBody(const RobotState& state, const ProtocolTerms& terms,
                                            std::optional<std::uint32_t> state_header_id);

}  // namespace fleetpub::simulator
