// Robots of version 3.0 keep instant actions that have ended until clearInstantActions: clears those
// lists once nobody of ours waits any more.
#pragma once

#include <set>
#include <span>
#include <string>

#include "app/environment.h"
#include "app/observer.h"
#include "app/robot_discovery.h"
#include "ledger/ledger.h"
#include "message/report.h"
#include "mqtt/transport.h"

namespace fleetpub::app {

class TidyUp {
 public:
  /// `is_asked`: after every action of ours that a robot keeps; else when a robot says that its list
  /// is full.
  explicit TidyUp(bool is_asked) : is_asked_(is_asked) {}

  /// What became of a command.
  void Add(const message::Report& report);

  /// Clears the lists of those of these robots that need it, waits for their word, and tells what
  /// came of it. Changes nobody's result.
  void Run(std::span<const ListedRobot* const> robots, Link& link, ledger::Ledger& ledger,
           mqtt::Qos qos, const std::string& schema_directory, Observer& observer) const;

 private:
  bool is_asked_;
  std::set<std::string> targets_;
};

}  // namespace fleetpub::app
