// Which robots there are, and how each is spoken to: found in the messages that they left retained
// (`--vda auto`, patterns, preflight). The topic's levels give address, interface and major
// version, the header's `version` the release.
#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// Of whom messages are wanted; what is not given is everybody.
struct RobotFilter {
  std::optional<std::string> manufacturer;
  std::optional<std::string> serial_number;
};

/// One MQTT filter per topic name (`connection`, `factsheet`, `state`): `+/+/KIT/0001/connection`.
/// {interface} becomes `+` unless the scheme states one, {major} always. Errors: ErrorKind::kUsage
/// (template, or a name that cannot be a topic level).
[[nodiscard]] Result<std::vector<std::string>> DiscoveryFilters(
    const TopicScheme& scheme, const RobotFilter& filter,
    std::span<const std::string_view> topic_names);

/// The robot's topics as every release would make them, each once: `uagv/v1/KIT/0001/connection`,
/// `uagv/v2/…`, `vda5050/v3/…`. For brokers that keep retained messages for exact topics only
/// (RabbitMQ). Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::vector<std::string>> SpecifiedTopics(
    const TopicScheme& scheme, const RobotAddress& robot,
    std::span<const std::string_view> topic_names);

/// Where one robot may be, whatever the broker: DiscoveryFilters, then SpecifiedTopics. Errors: as
/// these.
[[nodiscard]] Result<std::vector<std::string>> TopicsAnywhere(
    const TopicScheme& scheme, const RobotAddress& robot,
    std::span<const std::string_view> topic_names);

/// DiscoveryFilters for each of these places (TopicLevels::Place) and each that the releases have.
/// Errors: as that.
[[nodiscard]] Result<std::vector<std::string>> FiltersByPlace(
    const TopicScheme& scheme, std::set<std::string> places, const RobotFilter& filter,
    std::span<const std::string_view> topic_names);

/// The levels of a topic that the scheme's template would make.
struct TopicLevels {
  RobotAddress robot;
  std::string interface_name;  ///< "" when the template has none
  std::string major;           ///< "" when the template has none
  std::string topic_name;      ///< `connection`

  /// `uagv/v2`: under which all topics of a robot lie. Several of one robot are old ones that it
  /// has left behind, or robots that bear one name.
  [[nodiscard]] std::string Place() const { return interface_name + "/" + major; }
};

/// Reads a topic back. `manufacturer` is the one that a template without {manufacturer} leaves out.
/// Nothing when the template cannot have made it.
[[nodiscard]] std::optional<TopicLevels> ReadTopic(const TopicScheme& scheme,
                                                   std::string_view topic,
                                                   std::string_view manufacturer = {});

/// Another topic of the same robot at the same place. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::string> TopicBeside(const TopicScheme& scheme, const TopicLevels& levels,
                                              std::string_view topic_name);

/// A robot's message that says who and how it is.
struct Discovered {
  RobotAddress robot;
  std::string topic;       ///< in full
  std::string topic_name;  ///< `connection`
  /// How to speak to it, with its own interface, topic level and, where they are peculiar, its own
  /// header texts. Nothing when it speaks a version that we do not.
  std::optional<Dialect> dialect;
  std::string place;  ///< TopicLevels::Place
  /// Read as a connection message: `connection_state` is empty for other topics.
  ConnectionMessage message;
};

/// What a message of any topic tells about its sender. Nothing for an empty payload (a retained
/// message that was deleted), one that is no JSON object and a topic of another shape. `base` is
/// the dialect as the user configured it: what it states outright (interface, header texts, actions
/// key) is kept, its version is not looked at.
[[nodiscard]] std::optional<Discovered> DialectFrom(const Dialect& base, std::string_view topic,
                                                    std::string_view payload);

/// The same of a message that has been read already.
[[nodiscard]] std::optional<Discovered> DialectFrom(const Dialect& base, std::string_view topic,
                                                    ConnectionMessage message);

/// Which of several places of one robot is to be believed: the greater one. One at which it was
/// heard live goes before what is retained, a connection message before others, ONLINE before
/// HIBERNATING before the rest, then the newest timestamp, then the newest version.
struct Standing {
  bool is_live = false;
  int rank = -1;
  std::optional<base::WallTime> time;
  std::optional<Version> version;

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy takes the 0 that it implies for a pointer.
  friend auto operator<=>(const Standing&, const Standing&) = default;
};

[[nodiscard]] Standing ToStanding(const Discovered& found);

}  // namespace fleetpub::vda5050
