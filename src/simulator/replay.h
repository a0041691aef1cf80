// Says again what the robots of a recording said, at the pace at which they said it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mqtt/transport.h"
#include "recording/reader.h"
#include "vda5050/model/robot_pattern.h"

namespace fleetpub::simulator {

/// `KIT/0001=TEST/0001`, `KIT/*=TEST/*`.
struct RobotMapping {
  vda5050::RobotPattern from;
  std::string manufacturer;   ///< `*`: as it was
  std::string serial_number;  ///< likewise
};

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<RobotMapping> ParseRobotMapping(std::string_view text);

struct ReplayOptions {
  std::filesystem::path file;
  vda5050::TopicScheme scheme;
  std::vector<RobotMapping> mappings;  ///< none: everybody under their own names; else these alone
  double speed = 1;
  bool restamp = false;           ///< headers count and date anew
  bool commands = false;          ///< what fleet control said, too
  bool keep = false;              ///< what is retained stays at the end
  bool force = false;             ///< in the place of robots that are ONLINE
  std::function<bool()> stopped;  ///< asked several times a second
};

/// What a replay would send.
struct ReplayPlan {
  std::set<vda5050::RobotAddress> robots;  ///< in whose names
  std::set<std::string> retained;          ///< topics on which a message is left
  std::set<std::string> places;            ///< their connection topics
  std::uint64_t messages = 0;
  std::uint64_t commands = 0;  ///< for robots, whether or not they are sent
  std::uint64_t others = 0;    ///< of other robots and other topics, which are not
  std::chrono::microseconds lasts{0};
  recording::Faults faults;
};

/// Reads it all. Errors: ErrorKind::kLedger, kInvalid; kUsage: a mapping gives a name that no robot can
/// have, or one name to two robots; kPreflight: there is nothing to send.
[[nodiscard]] Result<ReplayPlan> PlanReplay(const ReplayOptions& options);

struct Replayed {
  std::uint64_t messages = 0;
  std::uint64_t again = 0;              ///< that were sent a second time: nobody knows of the first
  std::uint64_t losses = 0;             ///< of the connection
  std::chrono::microseconds lost{0};    ///< for so long in all; the recording stood still meanwhile
  std::chrono::microseconds latest{0};  ///< the message that came latest behind its time
  bool was_stopped = false;
};

struct ReplayHooks {
  std::function<Result<std::unique_ptr<mqtt::RobotTransport>>()> open;
  /// The connection was lost and is now opened again; it is there again, after so long.
  std::function<void(const Error&)> lost;
  std::function<void(std::chrono::microseconds)> again;
};

/// Sends it over an open connection. One that is lost is opened again for as long as nobody stops it;
/// then what the broker has not acknowledged is sent once more, and what it has retained no more. What
/// was retained at these topics before is put back at the end. Errors: as PlanReplay; kBroker, also
/// for what it refused or did not acknowledge; kPreflight: a robot of such a name is ONLINE.
[[nodiscard]] Result<Replayed> Replay(const ReplayOptions& options, const ReplayPlan& plan,
                                      std::unique_ptr<mqtt::RobotTransport> transport,
                                      const ReplayHooks& hooks);

}  // namespace fleetpub::simulator
