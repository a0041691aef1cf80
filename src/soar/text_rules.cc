#include "soar/text_rules.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/json.h"
#include "base/text.h"
#include "soar/message_type.h"

namespace fleetpub::soar {
namespace {

using base::FindMember;
using base::StringMember;
using rapidjson::SizeType;
using Value = base::JsonValue;

constexpr double kMostLatitude = 90;
constexpr double kMostLongitude = 180;
constexpr std::array<std::string_view, 6> kActions = {"move",      "payload",  "dive",
                                                      "send_hits", "scanline", "scanpoint"};

// `/payload/plan/2/action` → `plan[2].action`.
std::string PlaceInWords(std::string_view path) {
  constexpr std::string_view kPayload = "/payload";
  if (path.starts_with(kPayload)) path.remove_prefix(kPayload.size());
  std::string words;
  for (const std::string& token : base::Split(path, '/')) {
    if (token.empty()) continue;
    const bool is_index = token.find_first_not_of("0123456789") == std::string::npos;
    words += is_index ? fmt::format("[{}]", token) : (words.empty() ? "" : ".") + token;
  }
  return words;
}

// Walks through one payload. `path` is always the JSON Pointer of the value beside it. What a
// user's own schema let pass and is of another kind is passed over.
class Checker {
 public:
  Checker(Strictness strictness, std::vector<message::TextFinding>& findings)
      : is_error_(strictness == Strictness::kRefuse), findings_(findings) {}

  void Header(const Value& header, const std::string& path) {
    const std::string_view destination = StringMember(header, "destination");
    const bool is_broadcast = StringMember(header, "delivery_type") == "broadcast";
    if (is_broadcast != (destination == "broadcast") && !destination.empty()) {
      Add(path + "/delivery_type",
          "the destination of a broadcast, and of nothing else, is "
          "broadcast");
    }
  }

  // The last level of a long destination names the payload.
  void Match(const Value& header, const Value& payload, const std::string& path) {
    const std::string_view destination = StringMember(header, "destination");
    const std::string_view last = destination.substr(destination.rfind('.') + 1);
    if (!ParseMessageType(last) || last == StringMember(payload, "message_type")) return;
    Add(path + "/destination", fmt::format("it ends in {}, the payload is a {}", last,
                                           base::Printable(StringMember(payload, "message_type"))));
  }

  void Payload(const Value& payload, const std::string& path) {
    const auto type = ParseMessageType(StringMember(payload, "message_type"));
    if (!type) return;
    switch (*type) {
      case MessageType::kMissionPlan:
        return MissionPlan(payload, path);
      case MessageType::kObservation:
        return Each(payload, "points_of_interest", path, &Checker::Place);
      case MessageType::kPlanningConfiguration:
        return PlanningConfiguration(payload, path);
      case MessageType::kPlatformStatus:
        return Status(payload, path);
      case MessageType::kAcknowledgement:
        return;
    }
  }

 private:
  using Check = void (Checker::*)(const Value&, const std::string&);

  void Add(std::string path, std::string_view message) {
    std::string told = fmt::format("{}: {}", PlaceInWords(path), message);
    findings_.push_back({{std::move(path), std::move(told)}, is_error_});
  }

  void Each(const Value& object, std::string_view name, const std::string& path, Check check) {
    const Value* list = FindMember(object, name);
    if (list == nullptr || !list->IsArray()) return;
    for (SizeType i = 0; i < list->Size(); ++i) {
      (this->*check)((*list)[i], fmt::format("{}/{}/{}", path, name, i));
    }
  }

  static std::optional<double> NumberIn(const Value& object, std::string_view name) {
    const Value* value = FindMember(object, name);
    if (value == nullptr || !value->IsNumber()) return std::nullopt;
    return value->GetDouble();
  }

  void Range(const Value& object, std::string_view name, double least, double most,
             const std::string& path) {
    const auto number = NumberIn(object, name);
    if (!number || (*number >= least && *number <= most)) return;
    Add(fmt::format("{}/{}", path, name),
        fmt::format("{} is not between {} and {}", *number, least, most));
  }

  // Swapped coordinates are the usual mistake: say so where it would explain them.
  void Coordinates(const Value& object, std::string_view latitude, std::string_view longitude,
                   const std::string& path) {
    const auto north = NumberIn(object, latitude);
    Range(object, longitude, -kMostLongitude, kMostLongitude, path);
    if (!north || (*north >= -kMostLatitude && *north <= kMostLatitude)) return;
    const bool swapped = *north >= -kMostLongitude && *north <= kMostLongitude;
    Add(fmt::format("{}/{}", path, latitude),
        fmt::format("{} is not between -90 and 90{}", *north,
                    swapped ? ": are latitude and longitude swapped?" : ""));
  }

  void Place(const Value& object, const std::string& path) {
    Coordinates(object, "latitude", "longitude", path);
  }
  void Waypoint(const Value& object, const std::string& path) {
    Coordinates(object, "latitude_waypoint", "longitude_waypoint", path);
    const std::string_view action = StringMember(object, "action");
    for (const std::string_view known : kActions) {
      if (action == known) return;
    }
    if (const auto near = base::Nearest(action, kActions)) {
      Add(path + "/action", fmt::format("'{}' is not a named action: did you mean {}?",
                                        base::Printable(action), *near));
    }
  }

  void MissionPlan(const Value& payload, const std::string& path) {
    const Value* plan = FindMember(payload, "plan");
    if (plan != nullptr && plan->IsArray() && plan->Empty()) Add(path + "/plan", "it is empty");
    Each(payload, "plan", path, &Checker::Waypoint);
  }

  void Status(const Value& payload, const std::string& path) {
    Place(payload, path);
    Range(payload, "heading", 0, 360, path);
    Range(payload, "battery_remaining_capacity", 0, 100, path);
  }

  void PlanningConfiguration(const Value& payload, const std::string& path) {
    const Value* squads = FindMember(payload, "squads");
    if (squads != nullptr && squads->IsArray() && squads->Empty()) {
      Add(path + "/squads", "it is empty");
    }
    Each(payload, "squads", path, &Checker::Squad);
    Each(payload, "exclusion_zones", path, &Checker::Region);
  }

  void Squad(const Value& squad, const std::string& path) {
    Once(squad, "squad_ID", squads_, path);
    const Value* platforms = FindMember(squad, "platforms");
    const auto number = NumberIn(squad, "no_of_platforms");
    if (number && platforms != nullptr && platforms->IsArray() && *number != platforms->Size()) {
      Add(path + "/no_of_platforms",
          fmt::format("{} is not the number of its platforms, {}", *number, platforms->Size()));
    }
    Each(squad, "platforms", path, &Checker::Platform);
    if (const Value* region = FindMember(squad, "region_of_interest")) {
      Region(*region, path + "/region_of_interest");
    }
  }

  void Platform(const Value& platform, const std::string& path) {
    Once(platform, "platform_ID", platforms_, path);
    const auto slowest = NumberIn(platform, "min_velocity");
    const auto fastest = NumberIn(platform, "max_velocity");
    if (slowest && fastest && *slowest > *fastest) {
      Add(path + "/min_velocity", fmt::format("{} is above max_velocity, {}", *slowest, *fastest));
    }
    if (const Value* emergency = FindMember(platform, "emergency")) {
      Coordinates(*emergency, "latitude_waypoint", "longitude_waypoint", path + "/emergency");
    }
  }

  void Once(const Value& object, std::string_view name, std::map<double, std::string>& seen,
            const std::string& path) {
    const auto number = NumberIn(object, name);
    if (!number) return;
    const std::string place = fmt::format("{}/{}", path, name);
    const auto [first, is_new] = seen.emplace(*number, place);
    if (!is_new) Add(place, fmt::format("{} stands at {} already", *number, first->second));
  }

  // Rings of [longitude, latitude]; a closed ring repeats its first point.
  void Region(const Value& region, const std::string& path) {
    const Value* rings = FindMember(region, "geometry_coordinates");
    if (rings == nullptr || !rings->IsArray()) return;
    const std::string above = path + "/geometry_coordinates";
    for (SizeType i = 0; i < rings->Size(); ++i) {
      Ring((*rings)[i], fmt::format("{}/{}", above, i));
    }
    if (rings->Empty()) Add(above, "it is empty");
  }

  void Ring(const Value& ring, const std::string& path) {
    constexpr SizeType kCorners = 4;
    if (!ring.IsArray()) return Add(path, "a ring is an array of points");
    const bool closed = ring.Size() == kCorners + 1 && ring[0] == ring[kCorners];
    if (ring.Size() != kCorners && !closed) {
      Add(path, fmt::format("a zone has four points, not {}", ring.Size()));
    }
    for (SizeType i = 0; i < ring.Size(); ++i) Point(ring[i], fmt::format("{}/{}", path, i));
  }

  void Point(const Value& point, const std::string& path) {
    const bool pair =
        point.IsArray() && point.Size() >= 2 && point[0].IsNumber() && point[1].IsNumber();
    if (!pair) return Add(path, "a point is [longitude, latitude]");
    const double east = point[0].GetDouble();
    const double north = point[1].GetDouble();
    if (east < -kMostLongitude || east > kMostLongitude || north < -kMostLatitude ||
        north > kMostLatitude) {
      Add(path, fmt::format("[{}, {}] is not a longitude between -180 and 180 and latitude between "
                            "-90 and 90",
                            east, north));
    }
  }

  bool is_error_;
  std::vector<message::TextFinding>& findings_;
  std::map<double, std::string> squads_;
  std::map<double, std::string> platforms_;
};

}  // namespace

std::vector<message::TextFinding> CheckMessage(const Value& message, Strictness strictness) {
  std::vector<message::TextFinding> findings;
  Checker checker(strictness, findings);
  const Value* payload = FindMember(message, "payload");
  if (payload == nullptr) {
    checker.Payload(message, "");
    return findings;
  }
  if (const Value* header = FindMember(message, "header")) {
    checker.Header(*header, "/header");
    checker.Match(*header, *payload, "/header");
  }
  checker.Payload(*payload, "/payload");
  return findings;
}

}  // namespace fleetpub::soar
