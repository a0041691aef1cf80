// What robots say on their topics state, connection and factsheet, in the names of every version,
// read leniently. A message that breaks its schema is read as far as it can be: a missing
// member or one of a wrong type is "not said", unknown members, statuses and modes are no obstacle,
// a number or a truth value is taken where a text is due. Only a payload that is no JSON object
// even for base::ParseJsonLeniently cannot be read: the error says why.
//
// Everything is copied out of the message: the payload need not outlive the result. Texts are the
// robot's own and untrusted: whoever shows one passes it through base::Printable.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/rapidjson.h"
#include "base/result.h"
#include "base/time.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::vda5050 {

/// How long a robot that is there may say nothing: states come at least every 30 s (1.1–2.1 §6.6 and
/// §6.10, 3.0 §6.6), and some more for the way.
inline constexpr std::chrono::seconds kLongestSilence{35};

/// What every message begins with.
struct MessageHeader {
  std::optional<std::uint32_t> header_id;
  std::optional<std::uint64_t> count;  ///< the header id, also one that is too large to be one
  std::string timestamp;               ///< as written
  std::string version;                 ///< as written: `2.0.0`, but `v2` too
  std::string manufacturer;
  std::string serial_number;
};

/// An entry of `actionStates` or `instantActionStates`.
struct ActionState {
  std::string id;
  std::string type;    ///< often left out by robots
  std::string status;  ///< upper case: 1.1's schema has `finished`
  std::string result;  ///< `resultDescription`, from 3.0 `actionResult`
};

struct ErrorReference {
  std::string key;
  std::string value;
};

/// An entry of `errors`.
struct RobotError {
  std::string type;
  std::string level;        ///< upper case
  std::string description;  ///< or its English (else first) translation when only those are given
  std::string hint;         ///< likewise
  std::vector<ErrorReference> references;
};

/// An entry of `information`.
struct RobotInformation {
  std::string type;
  std::string level;        ///< upper case
  std::string description;  ///< `infoDescription`, from 3.0 `infoDescriptor`
  std::vector<ErrorReference> references;
};

/// An entry of `loads`.
struct RobotLoad {
  std::string id;
  std::string type;
  std::string position;
  std::optional<double> weight;  ///< kg
};

/// An entry of `nodeStates`: a node that lies ahead.
struct NodeState {
  std::string id;
  std::uint32_t sequence_id = 0;
  bool released = true;
};

/// `agvPosition`, from 3.0 `mobileRobotPosition`.
struct RobotPosition {
  std::optional<double> x;
  std::optional<double> y;
  std::optional<double> theta;
  std::string map_id;
  std::optional<bool> localized;  ///< `positionInitialized`, from 3.0 `localized`
};

/// An entry of `zoneSets` (3.0).
struct ZoneSetState {
  std::string id;
  std::string map_id;
  std::string status;  ///< upper case
};

/// An entry of `zoneRequests` or `edgeRequests` (3.0): the robot asks for a permission.
struct RobotRequest {
  std::string id;      ///< `requestId`
  std::string type;    ///< `requestType`: ACCESS, REPLANNING, CORRIDOR; upper case
  std::string status;  ///< `requestStatus`: REQUESTED, GRANTED, REVOKED, EXPIRED; upper case
  std::string zone_id;
  std::string zone_set_id;
  std::string edge_id;
  std::optional<std::uint32_t> sequence_id;  ///< of the edge
};

struct RobotState {
  MessageHeader header;
  std::vector<ActionState> action_states;
  std::vector<ActionState> instant_action_states;  ///< from 3.0
  std::vector<ActionState> zone_action_states;     ///< from 3.0
  bool has_action_states = false;                  ///< the array is there, be it empty
  bool has_instant_action_states = false;
  std::vector<RobotError> errors;
  std::string operating_mode;  ///< normalised, see NormalisedMode; empty: not said
  std::optional<bool> paused;
  std::optional<bool> driving;
  std::optional<double> battery_charge;  ///< per cent
  std::optional<bool> charging;
  std::optional<double> battery_voltage;  ///< V
  std::optional<double> battery_health;   ///< per cent
  std::optional<double> range;            ///< m: `reach`, from 3.0 `range`
  std::string emergency_stop;  ///< normalised, see NormalisedEmergencyStop; empty: not said
  std::optional<bool> field_violation;
  std::string order_id;
  std::optional<std::uint32_t> order_update_id;
  std::optional<std::size_t> nodes_left;  ///< entries of `nodeStates`
  std::optional<std::size_t> edges_left;  ///< entries of `edgeStates`
  std::vector<NodeState> nodes;           ///< `nodeStates`: those that have a sequenceId
  std::optional<bool> new_base_request;
  std::string last_node_id;
  std::optional<std::uint32_t> last_node_sequence_id;
  std::optional<RobotPosition> position;
  std::vector<ZoneSetState> zone_sets;
  std::vector<RobotRequest> requests;           ///< for zones, then for edges
  std::optional<std::vector<RobotLoad>> loads;  ///< nothing: it cannot tell
  std::vector<RobotInformation> information;
};

struct ConnectionMessage {
  MessageHeader header;
  std::string connection_state;  ///< normalised, see NormalisedConnectionState; empty: not said
  std::string fault{};           ///< why it could not be read; empty: it could
};

/// An action's parameter as the factsheet describes it.
struct FactsheetParameter {
  std::string key;
  std::string value_type;             ///< `valueDataType`, upper case
  std::optional<bool> is_optional{};  ///< often left out

  bool operator==(const FactsheetParameter&) const = default;
};

struct FactsheetAction {
  std::string type;
  std::vector<std::string> scopes;  ///< upper case; empty: not said
  std::vector<FactsheetParameter> parameters;
  bool has_parameters = false;              ///< the array is there, be it empty
  std::vector<std::string> blocking_types;  ///< upper case; empty: not said

  bool operator==(const FactsheetAction&) const = default;
};

/// `protocolLimits` as far as they concern what we send. 0: no limit.
struct FactsheetLimits {
  std::size_t message_length = 0;
  std::size_t topic_serial_length = 0;
  std::size_t topic_element_length = 0;
  std::size_t id_length = 0;
  bool id_numerical_only = false;
  std::size_t instant_actions = 0;    ///< per message
  std::size_t action_parameters = 0;  ///< per action
  std::size_t order_nodes = 0;
  std::size_t order_edges = 0;
  std::size_t node_actions = 0;
  std::size_t edge_actions = 0;
  std::size_t trajectory_knots = 0;
  std::size_t trajectory_points = 0;
  std::size_t base_nodes = 0;  ///< released ones that the robot keeps (`state.nodeStates`)

  bool operator==(const FactsheetLimits&) const = default;
};

/// An entry of `optionalParameters`: what is not listed is not supported (3.0 §7.10).
struct OptionalParameter {
  std::string name;  ///< `order.nodes.nodePosition.theta`
  bool is_required = false;

  bool operator==(const OptionalParameter&) const = default;
};

/// `typeSpecification` and `physicalParameters`, in the names of 3.0.
struct RobotSpecification {
  std::string series;
  std::string series_description;
  std::string robot_class;              ///< `agvClass`, from 3.0 `mobileRobotClass`
  std::string kinematics;               ///< `agvKinematic`, from 3.0 `mobileRobotKinematics`
  std::optional<double> maximum_load;   ///< kg
  std::optional<double> maximum_speed;  ///< m/s
  std::optional<double> length;         ///< m, as the next two
  std::optional<double> width;
  std::optional<double> maximum_height;

  bool operator==(const RobotSpecification&) const = default;
};

struct Factsheet {
  MessageHeader header;
  std::vector<FactsheetAction> actions;  ///< empty: not said
  FactsheetLimits limits;
  std::vector<OptionalParameter> optional_parameters;
  bool has_optional_parameters = false;  ///< the array is there, be it empty
  RobotSpecification specification;
};

/// The payload as a JSON object.
[[nodiscard]] Result<base::JsonDocument> ReadMessage(std::string_view payload);
/// The payload as JSON in one line, as the robot wrote it if that is such a line; "" when it is no
/// JSON object.
[[nodiscard]] std::string ToOneLine(std::string_view payload);
[[nodiscard]] Result<RobotState> ReadState(std::string_view payload);
[[nodiscard]] RobotState ReadState(const base::JsonValue& message);
[[nodiscard]] Result<ConnectionMessage> ReadConnection(std::string_view payload);
[[nodiscard]] ConnectionMessage ReadConnection(const base::JsonValue& message);
[[nodiscard]] Result<Factsheet> ReadFactsheet(std::string_view payload);
[[nodiscard]] Factsheet ReadFactsheet(const base::JsonValue& message);
[[nodiscard]] MessageHeader ReadHeader(const base::JsonValue& message);

/// When a robot says that it made a message: date-time, also without a zone (UTC, then), with a
/// blank for the T, with an offset without colon, and a number of milliseconds. Robots are not held
/// to agree with our clock.
[[nodiscard]] std::optional<base::WallTime> ReadTime(const MessageHeader& header);

/// Whether one message of a topic was made before another. Only when header id and timestamp say so
/// together: a falling id alone is a robot that was restarted, a falling time alone its clock. One
/// of them may be equal.
[[nodiscard]] bool IsBefore(const MessageHeader& a, const MessageHeader& b);

/// Empty when this header may be of a robot that goes by one of these names: it says nothing else,
/// letter case aside. Otherwise the name that it says instead, printable.
[[nodiscard]] std::string OtherSender(const MessageHeader& header,
                                      std::span<const RobotAddress> names);

/// The action's entry, in whichever array it stands, or null. Some robots list a repeated action
/// twice: then the entry that has come furthest, but FAILED before FINISHED. An entry that is of
/// another action type than `type` is passed over; an empty `type` is any. The pointer lives as
/// long as `state`.
[[nodiscard]] const ActionState* FindActionState(const RobotState& state, std::string_view id,
                                                 std::string_view type = {});

/// Whether it says that an emergency stop is active.
[[nodiscard]] bool IsEmergencyStopped(const RobotState& state);

/// `driving`, `standing`, `paused`: what a person wants to know first.
[[nodiscard]] std::string_view DescribeMotion(const RobotState& state);

/// FINISHED or FAILED. An unknown status is none.
[[nodiscard]] bool IsTerminal(std::string_view status);

/// The factsheet's entry for the action, or null.
[[nodiscard]] const FactsheetAction* FindAction(const Factsheet& factsheet, std::string_view type);

/// `ONLINE`, `OFFLINE`, `HIBERNATING`, `CONNECTION_BROKEN` as 3.0 spells them, for any letter case
/// and for `CONNECTIONBROKEN` and `DISCONNECTED` (so the schemas of 2.x call OFFLINE in their text);
/// another text in upper case.
[[nodiscard]] std::string NormalisedConnectionState(std::string_view text);

/// OFFLINE, CONNECTION_BROKEN or HIBERNATING: such a robot answers nobody.
[[nodiscard]] bool IsAway(std::string_view connection_state);

/// `OFFLINE since 2026-…`. A last will is dated when the robot connected, not when it broke:
/// `CONNECTION_BROKEN (connected at 2026-…)`. Printable.
[[nodiscard]] std::string ConnectionText(const ConnectionMessage& connection);

/// `AUTOMATIC`, `SEMIAUTOMATIC`, `TEACH_IN` … as 3.0 spells them, for any letter case and for
/// `SEMI-AUTOMATIC`, `TEACHIN`, `TEACHING`; another text in upper case.
[[nodiscard]] std::string NormalisedMode(std::string_view text);

/// `AUTOACK`, `MANUAL`, `REMOTE`, `NONE`, for any letter case and for `AUTO_ACK`; another text in
/// upper case.
[[nodiscard]] std::string NormalisedEmergencyStop(std::string_view text);

/// What a robot said, for a sentence: printable and at most `longest` bytes, cut with `…`.
[[nodiscard]] std::string Shown(std::string_view text, std::size_t longest = 200);

}  // namespace fleetpub::vda5050
