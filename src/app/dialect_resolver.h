// How a robot is spoken to: version, topics and header, as flags and configuration say.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "config/config.h"
#include "vda5050/messages/instant_actions.h"

namespace fleetpub::app {

/// What somebody has said; an empty text says nothing.
struct VdaOptions {
  std::string version;  ///< empty or `auto`: as each robot's own messages say
  std::string interface_name;
  std::string topic_template;
  std::string actions_key;
  std::string header_version;
  std::string header_manufacturer;
  std::string header_serial;

  [[nodiscard]] bool IsAutomatic() const { return version.empty() || version == "auto"; }
};

/// `given`, completed with what the configuration says of everybody.
[[nodiscard]] VdaOptions WithConfig(VdaOptions given, const config::Config& config);
/// `given`, completed with what the configuration says of this robot, and of everybody.
[[nodiscard]] VdaOptions WithConfig(VdaOptions given, const config::Config& config,
                                    const vda5050::RobotAddress& robot);

/// Errors: ErrorKind::kUsage.
[[nodiscard]] Result<vda5050::Dialect> ParseDialect(const VdaOptions& options);

/// Robots of one make mostly share a dialect.
struct AddressedRobot {
  vda5050::RobotAddress robot;
  /// That it is spoken to in at first; not null. Its version is assumed where nobody states one.
  std::shared_ptr<const vda5050::Dialect> dialect;
  bool automatic = false;  ///< then in its own
};

/// Robots whose topics may not tell them apart: a template may leave {manufacturer} or {topic} out.
class TopicOwners {
 public:
  /// `waits`: something of the robot is to be heard. Errors: ErrorKind::kUsage: another robot has the
  /// same topics, or nothing is heard of this one.
  [[nodiscard]] Status Add(const vda5050::RobotAddress& robot, const vda5050::TopicScheme& scheme,
                           bool waits);

 private:
  std::map<std::string, vda5050::RobotAddress> by_serial_;  // where {manufacturer} is left out
};

/// How each robot is spoken to at first, as flags and configuration say.
class DialectResolver {
 public:
  /// Errors: ErrorKind::kUsage.
  [[nodiscard]] static Result<DialectResolver> Make(const VdaOptions& given,
                                                    const config::Config& config);

  /// In its own version unless somebody states one. Errors: ErrorKind::kUsage, in the robot's own
  /// table.
  [[nodiscard]] Result<AddressedRobot> Resolve(vda5050::RobotAddress robot) const;

  /// The message says which version it is in: that of all for whom nobody states one.
  void Assume(vda5050::Version version);

  /// The shapes that robots' topics may have. Errors: ErrorKind::kUsage, in a robot's table.
  [[nodiscard]] Result<std::vector<vda5050::TopicScheme>> Schemes() const;

  /// How robots without a table of their own are spoken to.
  [[nodiscard]] const vda5050::Dialect& common() const { return *common_; }

 private:
  DialectResolver(VdaOptions given, const config::Config& config)
      : given_(std::move(given)), config_(&config) {}

  VdaOptions given_;
  const config::Config* config_;
  std::shared_ptr<const vda5050::Dialect> common_;
  std::optional<vda5050::Version> assumed_;
};

}  // namespace fleetpub::app
