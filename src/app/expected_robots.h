// Robots that should be there: the configuration names them, or they were commanded not long ago.
// What a broker hands out is held against them, and they can be asked for by name.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/environment.h"
#include "app/observer.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

struct ExpectedRobot {
  vda5050::RobotAddress robot;
  vda5050::TopicScheme scheme;  ///< of its topics
  bool was_commanded = false;   ///< at this site, in the last seven days
};

/// What was sent by one of these brokers in the last seven days, oldest first: the newest 10,000
/// messages. Nothing when the ledger cannot be read.
[[nodiscard]] std::vector<ledger::Record> FindRecentRows(const Environment& environment,
                                                         std::vector<std::string> brokers);

/// Nothing: this robot is not meant.
using SchemeHook =
    std::function<std::optional<vda5050::TopicScheme>(const vda5050::RobotAddress& robot)>;

/// In order of address. A ledger that cannot be read names none; of a long one the newest 10,000
/// messages count. `server` is the one in use.
[[nodiscard]] std::vector<ExpectedRobot> FindExpectedRobots(const Environment& environment,
                                                            const mqtt::ServerInfo& server,
                                                            const SchemeHook& scheme_of);

/// Those that are not among the heard ones.
[[nodiscard]] std::vector<ExpectedRobot> FindUnheard(
    std::vector<ExpectedRobot> expected,
    const std::function<bool(const vda5050::RobotAddress&)>& was_heard);

/// Whether these few, or whoever a broker leaves out, are to be asked for by name. Clouds take few
/// subscriptions of a connection.
[[nodiscard]] bool AreAskedByName(const std::vector<ExpectedRobot>& unheard, bool is_partial);

/// Their topics of this name, as every release makes them. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::vector<std::string>> TopicsByName(
    const std::vector<ExpectedRobot>& robots, std::string_view topic_name);

/// `3 robots commanded in the last 7 days did not answer: KIT/0004, …`; those that are only
/// configured are no warning.
void WarnOfUnheard(const std::vector<ExpectedRobot>& unheard, Log& log);

/// Nothing retained came for a filter with wildcards, though robots are there: who is found then.
void WarnOfWildcards(const mqtt::BrokerUrl& broker, Log& log);

}  // namespace fleetpub::app
