// Whom a SoAR message is for, and the MQTT topic made of it.
//
// The backbone's topics are words with dots between them; over MQTT each dot becomes a topic level:
//
//   <prefix>.<operator>.<platform_type>.<platform_identifier>.<direction>.<message_type>
//   soar.planet-ocean.ecosub.eco1.to_platform.mission_plan
//   soar/planet-ocean/ecosub/eco1/to_platform/mission_plan
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "soar/message_type.h"

namespace fleetpub::soar {

/// What all topics of a backbone begin with. Usually one level: `soar`.
struct Prefix {
  std::vector<std::string> levels = {"soar"};

  [[nodiscard]] std::string Dotted() const;
  /// A topic below it: `Topic("broadcast")` is `soar/broadcast`.
  [[nodiscard]] std::string Topic(std::string_view below) const;
};

/// A platform as its topics name it.
struct Platform {
  std::string operator_name;
  std::string type;
  std::string id;

  /// `planet-ocean/ecosub/eco1`
  [[nodiscard]] std::string Topic() const;
  friend bool operator==(const Platform&, const Platform&) = default;
};

struct Destination {
  std::string name;    ///< as people name it: `soar.planet-ocean.ecosub.eco1`, `ah1`, `broadcast`
  std::string header;  ///< what stands in `header.destination`
  std::string topic;   ///< of MQTT
  bool broadcast = false;
  std::optional<Platform> platform;  ///< none for a broadcast and for a short destination
  std::vector<std::string> warnings;
};

/// Levels with dots between them. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<Prefix> ParsePrefix(std::string_view text);

/// A destination for this type of message. One that names a platform gets direction and message
/// type appended when they are not there; one with fewer than four levels is used as it is,
/// under the prefix. A level that is empty, has `/ + # *`, a control character or invalid UTF-8
/// in it, a direction that is none, another message type, and more levels than there are: refused
/// with ErrorKind::kUsage.
[[nodiscard]] Result<Destination> ParseDestination(std::string_view text, const Prefix& prefix,
                                                   MessageType type);

/// `broadcast`, on `<prefix>/broadcast`.
[[nodiscard]] Destination Broadcast(const Prefix& prefix);

/// Who sends: a word, or several with dots between them. Errors: ErrorKind::kUsage.
[[nodiscard]] Status CheckSource(std::string_view source);

/// The topic filters on which acknowledgements of a message to this destination come back.
[[nodiscard]] std::vector<std::string> AcknowledgementTopics(const Destination& destination,
                                                             const Prefix& prefix,
                                                             std::string_view source);

/// The platform whose topic this is, `soar/planet-ocean/ecosub/eco1/…/…`; nothing when it is none.
[[nodiscard]] std::optional<Platform> FindPlatform(std::string_view topic, const Prefix& prefix);

}  // namespace fleetpub::soar
