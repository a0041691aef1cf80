#include "soar/destination.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "base/text.h"

namespace fleetpub::soar {
namespace {

using Levels = std::span<const std::string>;

constexpr std::string_view kTo = "to_platform";
constexpr std::string_view kFrom = "from_platform";
constexpr std::size_t kPlatformLevels = 3;     // operator, platform type, identifier
constexpr std::size_t kShortestLong = 4;       // fewer levels than that are a short destination
constexpr std::size_t kLongestTopic = 65'535;  // MQTT §1.5.3: strings have a 16-bit length
constexpr std::size_t kLongestKey = 255;  // AMQP 0-9-1 §4.2.5.3: a routing key's length is a byte

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }

// Why this may not be a level, or "".
std::string_view FaultOfLevel(std::string_view level) {
  if (level.empty()) return "a level is empty";
  if (level.find('/') != std::string_view::npos) return "levels are separated by dots, not by /";
  if (level.find_first_of("+#*") != std::string_view::npos) {
    return "+ # and * are wildcards and cannot be part of a name";
  }
  if (std::any_of(level.begin(), level.end(), IsControl)) return "it contains a control character";
  if (!base::IsUtf8(level)) return "it is not valid UTF-8";
  return "";
}

// `what` is "destination", "prefix" or "source".
Result<std::vector<std::string>> SplitLevels(std::string_view what, std::string_view text) {
  const auto refuse = [&](std::string_view why) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} '{}' is refused: {}", what, base::Printable(text), why));
  };
  if (text.empty()) return Fail(ErrorKind::kUsage, fmt::format("the {} is empty", what));
  if (text.size() > kLongestTopic / 2) return refuse("it is too long for a topic");
  auto levels = base::Split(text, '.');
  for (const std::string& level : levels) {
    if (const std::string_view fault = FaultOfLevel(level); !fault.empty()) return refuse(fault);
  }
  return levels;
}

std::string Joined(Levels levels, std::string_view separator) {
  return base::Join(levels, separator);
}

bool BeginsWith(Levels levels, Levels start) {
  return levels.size() >= start.size() && std::equal(start.begin(), start.end(), levels.begin());
}

Destination Short(std::string_view text, Levels below_prefix, const Prefix& prefix) {
  Destination destination;
  destination.name = text;
  destination.header = text;
  destination.topic = prefix.Topic(Joined(below_prefix, "/"));
  return destination;
}

// Direction and message type, checked where they are given.
Status CheckTail(Levels tail, std::string_view text, MessageType type) {
  const auto refuse = [&](std::string why) {
    return Fail(ErrorKind::kUsage,
                fmt::format("destination '{}' is refused: {}", base::Printable(text), why));
  };
  if (!tail.empty() && tail[0] != kTo && tail[0] != kFrom) {
    return refuse(fmt::format("after the platform comes to_platform or from_platform, not '{}'",
                              base::Printable(tail[0])));
  }
  if (tail.size() > 1 && tail[1] != GetName(type)) {
    return refuse(fmt::format("it ends in '{}', but the message is a {}", base::Printable(tail[1]),
                              GetName(type)));
  }
  if (tail.size() > 2) return refuse("it has more levels than a destination has");
  return {};
}

Result<Destination> Long(std::string_view text, Levels below_prefix, const Prefix& prefix,
                         MessageType type) {
  const Levels platform = below_prefix.first(kPlatformLevels);
  const Levels tail = below_prefix.subspan(kPlatformLevels);
  if (auto ok = CheckTail(tail, text, type); !ok) return Fail(ok.error());
  const std::string direction = tail.empty() ? std::string(GetDirection(type)) : tail[0];
  Destination destination;
  destination.platform = Platform{platform[0], platform[1], platform[2]};
  destination.name = fmt::format("{}.{}", prefix.Dotted(), Joined(platform, "."));
  destination.header = fmt::format("{}.{}.{}", destination.name, direction, GetName(type));
  destination.topic =
      prefix.Topic(fmt::format("{}/{}/{}", Joined(platform, "/"), direction, GetName(type)));
  if (direction != GetDirection(type)) {
    destination.warnings.push_back(
        fmt::format("a {} usually goes {}, not {}", GetName(type), GetDirection(type), direction));
  }
  return destination;
}

}  // namespace

std::string Prefix::Dotted() const { return Joined(levels, "."); }

std::string Prefix::Topic(std::string_view below) const {
  return fmt::format("{}/{}", Joined(levels, "/"), below);
}

std::string Platform::Topic() const { return fmt::format("{}/{}/{}", operator_name, type, id); }

Result<Prefix> ParsePrefix(std::string_view text) {
  auto levels = SplitLevels("prefix", text);
  if (!levels) return Fail(std::move(levels.error()));
  if (levels->front().starts_with('$')) {
    return Fail(ErrorKind::kUsage, fmt::format("prefix '{}' is refused: topics that begin with $ "
                                               "belong to the broker",
                                               base::Printable(text)));
  }
  return Prefix{*std::move(levels)};
}

Result<Destination> ParseDestination(std::string_view text, const Prefix& prefix,
                                     MessageType type) {
  const auto levels = SplitLevels("destination", text);
  if (!levels) return Fail(levels.error());
  if (text == "broadcast") {
    return Fail(ErrorKind::kUsage,
                "'broadcast' is not a destination: send to everybody with --broadcast");
  }
  const bool prefixed = BeginsWith(*levels, prefix.levels);
  const Levels below = prefixed ? Levels(*levels).subspan(prefix.levels.size()) : Levels(*levels);
  if (below.empty()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("destination '{}' is only the prefix: name somebody below it",
                            base::Printable(text)));
  }
  const bool is_long = prefixed && below.size() >= kPlatformLevels;
  if (!is_long && levels->size() >= kShortestLong) {
    return Fail(ErrorKind::kUsage,
                fmt::format("destination '{}' is refused: with four levels or more it begins with "
                            "the prefix {}, as in {}.planet-ocean.ecosub.eco1 (see --prefix)",
                            base::Printable(text), prefix.Dotted(), prefix.Dotted()));
  }
  Result<Destination> destination =
      is_long ? Long(text, below, prefix, type) : Short(text, below, prefix);
  if (!destination) return destination;
  if (!is_long && below.size() == kPlatformLevels) {
    destination->warnings.push_back(
        fmt::format("without the prefix it is used as it is; the platform is {0}.{1}",
                    prefix.Dotted(), base::Printable(text)));
  }
  if (destination->topic.size() > kLongestKey) {
    destination->warnings.push_back(fmt::format("the topic has {} bytes: an AMQP backbone takes {}",
                                                destination->topic.size(), kLongestKey));
  }
  return destination;
}

Destination Broadcast(const Prefix& prefix) {
  return {.name = "broadcast",
          .header = "broadcast",
          .topic = prefix.Topic("broadcast"),
          .broadcast = true,
          .platform = std::nullopt,
          .warnings = {}};
}

Status CheckSource(std::string_view source) {
  const auto levels = SplitLevels("source", source);
  if (!levels) return Fail(levels.error());
  return {};
}

std::vector<std::string> AcknowledgementTopics(const Destination& destination, const Prefix& prefix,
                                               std::string_view source) {
  const std::string tail = fmt::format("{}/{}", kFrom, GetName(MessageType::kAcknowledgement));
  if (destination.platform) {
    return {prefix.Topic(fmt::format("{}/{}", destination.platform->Topic(), tail))};
  }
  std::string own(source);
  std::replace(own.begin(), own.end(), '.', '/');
  return {prefix.Topic("+/+/+/" + tail), prefix.Topic(own)};
}

std::optional<Platform> FindPlatform(std::string_view topic, const Prefix& prefix) {
  const auto levels = base::Split(topic, '/');
  const std::size_t above = prefix.levels.size();
  if (levels.size() != above + kPlatformLevels + 2) return std::nullopt;
  if (!BeginsWith(levels, prefix.levels)) return std::nullopt;
  const std::string& direction = levels[above + kPlatformLevels];
  if (direction != kTo && direction != kFrom) return std::nullopt;
  return Platform{levels[above], levels[above + 1], levels[above + 2]};
}

}  // namespace fleetpub::soar
