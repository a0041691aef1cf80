// All that is known of one robot.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ledger/ledger.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/version.h"
#include "vda5050/reports/robot_directory.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::app {

/// Texts are the robot's own and untrusted.
struct RobotSheet {
  vda5050::RobotAddress robot;
  std::optional<vda5050::Version> version;  ///< in which it is spoken to; nothing: in none of ours
  std::string said_version;                 ///< as it writes it
  std::string place;                        ///< `uagv/v2`; "": not known
  std::optional<vda5050::ConnectionMessage> connection;
  bool speaks = false;    ///< it sends states, whatever its connection message says
  bool is_alive = false;  ///< it may be expected to send one
  /// Looked at as messages come: neither its factsheet nor its commands were asked for.
  bool is_watched = false;
  bool is_recorded = false;  ///< read from a recording: its commands were not asked for
  std::optional<vda5050::RobotState> state;
  bool state_is_retained = false;      ///< it is the past
  std::string state_fault;             ///< why the last one could not be read; "": it could
  std::chrono::milliseconds waited{};  ///< for a state
  std::shared_ptr<const vda5050::Factsheet> factsheet;
  std::string factsheet_fault;

  // Its messages as it wrote them, each as one line of JSON; "": none that is JSON.
  std::string connection_json;
  std::string state_json;
  std::string factsheet_json;

  std::string broker;  ///< where it is, as BrokerUrl::ToString; "": read from a recording
  std::vector<ledger::Record> commands;  ///< the last ones, over whichever broker, oldest first
  std::string commands_fault;            ///< why they are not known; "": they are
};

/// What the directory knows of it: no JSON, no commands.
[[nodiscard]] RobotSheet MakeRobotSheet(const vda5050::ListedRobot& robot);

}  // namespace fleetpub::app
