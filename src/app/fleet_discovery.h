// Looks on, once or for long: which robots of those that somebody means the broker knows, and what
// they say.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/choose_robots.h"
#include "app/dialect_resolver.h"
#include "app/environment.h"
#include "app/observer.h"
#include "app/targets.h"
#include "base/result.h"
#include "config/config.h"
#include "delivery/retained.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::app {

struct FleetRequest {
  TargetRequest targets;  ///< no words: all
  bool problems = false;  ///< only robots that somebody has to look after (HasProblem)
  VdaOptions vda;
  delivery::RetainedOptions discover = {};
  bool ask = false;  ///< robots that are there for their states
};

/// The robots that somebody means, and what is known of each: its last state, too.
class Fleet {
 public:
  /// Nothing is known yet. `config` must outlive it. Errors: ErrorKind::kUsage; kLedger: standard
  /// input cannot be read.
  [[nodiscard]] static Result<Fleet> Make(FleetRequest request, const config::Config& config,
                                          Log& log);

  /// The robot, when the message tells something of one.
  const ListedRobot* Take(const mqtt::Message& message);

  /// Whether it was seen and is among those that are asked for. One of which it is not known whether
  /// every --where is true is not.
  [[nodiscard]] bool Shows(const ListedRobot& robot) const;
  [[nodiscard]] bool Shows(const vda5050::RobotAddress& robot) const;
  /// These, in order of address.
  [[nodiscard]] std::vector<const ListedRobot*> robots() const;

  /// What to subscribe to. Errors: ErrorKind::kUsage.
  [[nodiscard]] Result<std::vector<std::string>> Filters() const;

  [[nodiscard]] const Targets& targets() const { return parts_->targets; }
  [[nodiscard]] const DialectResolver& resolver() const { return parts_->resolver; }
  [[nodiscard]] const Excluded& excluded() const { return parts_->excluded; }
  [[nodiscard]] vda5050::RobotDirectory& directory() { return parts_->directory; }
  [[nodiscard]] const vda5050::RobotDirectory& directory() const { return parts_->directory; }

  /// The words and options that choose them, as a person reads them; `all` without any.
  [[nodiscard]] std::string name() const;

 private:
  // Some refer to others.
  struct Parts {
    Targets targets;
    DialectResolver resolver;
    std::string words;
    bool problems;
    Excluded excluded = {};
    vda5050::RobotDirectory directory{{}, {}};
  };
  explicit Fleet(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

  std::unique_ptr<Parts> parts_;
};

/// What to say when so many robots' states could not be kept whole (RobotDirectory::abridged).
[[nodiscard]] std::string AbridgedWarning(std::size_t robots);

/// Shows what is known so far.
using FleetHook = std::function<void(const Fleet& fleet)>;

/// Waits until every robot that is online has sent a state, asked for it or not, and warns of those that did not in
/// time. `progress`, which may be empty, is called about every 100 ms meanwhile. Errors:
/// ErrorKind::kUsage, kBroker; kPreflight when no robot is known.
[[nodiscard]] Result<Fleet> DiscoverFleet(FleetRequest request, const Environment& environment,
                                          const FleetHook& progress, Log& log);

/// Shows a fleet as it is now. Called on one thread.
class FleetDisplay {
 public:
  virtual ~FleetDisplay() = default;

  virtual void Changed(const ListedRobot& robot) = 0;
  /// The connection was lost and is opened again.
  virtual void Lost(const Error& error) = 0;
  virtual void ConnectedAgain() = 0;
  /// About every 100 ms. False: the person has seen enough.
  [[nodiscard]] virtual Result<bool> Refresh(const Fleet& fleet) = 0;
};

/// Asks these robots for their states, and says what came of it.
using AskHook = std::function<std::string(const std::vector<vda5050::RobotAddress>& robots)>;

/// Makes the display once the broker has granted the subscription.
using DisplayHook = std::function<std::unique_ptr<FleetDisplay>(const mqtt::BrokerUrl& broker,
                                                                const Fleet& fleet, AskHook ask)>;

/// Shows what the robots say until `end` or until the display has enough; nobody is waited for.
/// Errors: ErrorKind::kUsage, kBroker; the display's.
[[nodiscard]] Status WatchFleet(FleetRequest request, mqtt::Deadline end,
                                const Environment& environment, const DisplayHook& make_display,
                                Log& log);

}  // namespace fleetpub::app
