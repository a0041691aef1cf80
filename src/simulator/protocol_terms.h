// In what the messages of a robot differ between the versions: names of members, of errors, of
// connection states (VDA 5050 1.1–2.1 §6.10–6.14, 3.0 §7).
#pragma once

#include <string_view>

#include "mqtt/transport.h"
#include "vda5050/model/version.h"

namespace fleetpub::simulator {

struct ProtocolTerms {
  vda5050::Version version;
  // connection
  std::string_view broken;  ///< the connectionState of the last will
  mqtt::Qos connection_qos;
  // state
  std::string_view position;
  std::string_view initialized;
  std::string_view power;
  std::string_view charge;
  std::string_view emergency_stop;
  std::string_view action_descriptor;
  std::string_view action_result;
  bool visualization_refers;  ///< with the headerId of a state
  bool own_instant_states;    ///< `instantActionStates` beside `actionStates`
  // errorType
  std::string_view invalid_action;
  std::string_view invalid_message;
  std::string_view no_order;
  std::string_view failed_action;
  std::string_view duplicate_map;
  std::string_view duplicate_zone_set;

  [[nodiscard]] bool HasFactsheet() const { return version >= vda5050::Version::k200; }
  [[nodiscard]] bool HasMaps() const { return version >= vda5050::Version::k210; }
  [[nodiscard]] bool HasZoneSets() const { return version >= vda5050::Version::k300; }
  [[nodiscard]] bool HasTrigger() const { return version >= vda5050::Version::k300; }
  [[nodiscard]] bool HasRetriable() const { return version >= vda5050::Version::k300; }
  /// Up to 2.1 the text says nothing on an action that a robot does not know; from 3.0 it is FAILED
  /// (Table 12).
  [[nodiscard]] bool FailsUnknownActions() const { return version >= vda5050::Version::k300; }
  /// Up to 2.1 a new order clears the ended actions from the state; from 3.0 clearInstantActions.
  [[nodiscard]] bool OrderClearsInstantActions() const { return version < vda5050::Version::k300; }
};

[[nodiscard]] const ProtocolTerms& GetTerms(vda5050::Version version);

}  // namespace fleetpub::simulator
