#include "cli/output/fleet_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "base/json.h"
#include "base/text.h"
#include "vda5050/reports/robot_errors.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using vda5050::ListedRobot;
using vda5050::RobotEntry;
using vda5050::Shown;

constexpr std::string_view kUnknown = "-";
constexpr std::size_t kLongestText = 40;  // of what a robot may write at any length

std::string TextOr(std::string_view text, std::string_view otherwise) {
  return text.empty() ? std::string(otherwise) : Shown(text, kLongestText);
}

Cell Target(const ListedRobot& robot) { return {base::Printable(robot.first.ToString())}; }

Cell FormatVersion(const RobotEntry& robot) {
  if (robot.own) return {std::string(vda5050::GetFacts(robot.own->version).name)};
  return {TextOr(robot.said_version, kUnknown)};
}

Cell Connection(const RobotEntry& robot) {
  if (!robot.connection) return {std::string(kUnknown)};
  if (!robot.connection->fault.empty()) return {"not readable", Tone::kBad};
  const std::string& said = robot.connection->connection_state;
  const Tone tone = said.empty() ? Tone::kPlain : robot.IsOnline() ? Tone::kGood : Tone::kBad;
  return {TextOr(said, kUnknown), tone};
}

// A last will says when the robot connected, not when it broke.
Cell Since(const RobotEntry& robot, base::WallTime now) {
  if (!robot.connection || robot.connection->connection_state == "CONNECTION_BROKEN") {
    return {std::string(kUnknown)};
  }
  const auto time = vda5050::ReadTime(robot.connection->header);
  if (!time) return {std::string(kUnknown)};
  return {AgeText(std::max(now - *time, std::chrono::system_clock::duration::zero()))};
}

Cell Mode(const RobotEntry& robot) {
  return {TextOr(robot.state ? robot.state->operating_mode : "", kUnknown)};
}

std::string YesNo(const std::optional<bool>& value) {
  return !value ? std::string(kUnknown) : *value ? "yes" : "no";
}

Cell Driving(const RobotEntry& robot) {
  return {YesNo(robot.state ? robot.state->driving : std::nullopt)};
}

Cell Paused(const RobotEntry& robot) {
  return {YesNo(robot.state ? robot.state->paused : std::nullopt)};
}

Cell Battery(const RobotEntry& robot) {
  const auto charge = robot.state ? robot.state->battery_charge : std::nullopt;
  std::string text = charge ? fmt::format("{:.0f}%", *charge) : std::string(kUnknown);
  if (robot.state && robot.state->charging == true) text += " charging";
  return {text};
}

Cell Order(const RobotEntry& robot) {
  return {robot.state ? TextOr(robot.state->order_id, "none") : std::string(kUnknown)};
}

Cell Errors(const RobotEntry& robot) {
  if (!robot.state_fault.empty()) return {"its state cannot be read", Tone::kBad};
  if (!robot.state) return {std::string(kUnknown)};
  const vda5050::RobotError* worst = vda5050::WorstError(robot.state->errors);
  if (worst == nullptr) return {"0"};
  const std::size_t count = robot.state->errors.size() + robot.state->errors_left_out;
  return {fmt::format("{} {}{}", count, TextOr(worst->level, kUnknown),
                      vda5050::IsInstantActionListFull(robot.state->errors) ? ", list full" : ""),
          Tone::kBad};
}

// The name, such as `,"alsoAt":`, with the text; nothing for an empty one.
std::string TextMember(std::string_view name, std::string_view text) {
  return text.empty() ? "" : std::string(name) + JsonString(text);
}

std::string TextOrNull(std::string_view text) { return text.empty() ? "null" : JsonString(text); }

std::string TruthOrNull(const std::optional<bool>& value) {
  return value ? fmt::format("{}", *value) : "null";
}

// jq takes null for less than every number: `select(.batteryCharge < 20)` would choose robots of
// which nothing is known. A text is greater.
std::string NumberOrUnknown(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : R"("unknown")";
}

std::string ErrorsJson(const std::vector<vda5050::RobotError>& errors) {
  std::string json;
  for (const vda5050::RobotError& error : errors) {
    json += fmt::format(R"({}{{"errorType":{},"errorLevel":{},"errorDescription":{}}})",
                        json.empty() ? "" : ",", JsonString(error.type), JsonString(error.level),
                        JsonString(error.description));
  }
  return "[" + json + "]";
}

std::string StateJson(const vda5050::LiveState* state) {
  if (!state) {
    return R"("operatingMode":null,"driving":null,"paused":null,"batteryCharge":"unknown",)"
           R"("charging":null,"orderId":null,"errors":null)";
  }
  return fmt::format(
             R"("operatingMode":{},"driving":{},"paused":{},"batteryCharge":{},"charging":{},)"
             R"("orderId":{},"errors":{})",
             TextOrNull(state->operating_mode), TruthOrNull(state->driving),
             TruthOrNull(state->paused), NumberOrUnknown(state->battery_charge),
             TruthOrNull(state->charging), JsonString(state->order_id), ErrorsJson(state->errors)) +
         (vda5050::IsInstantActionListFull(state->errors) ? R"(,"instantActionsFull":true)" : "");
}

}  // namespace

std::span<const Column> FleetColumns() {
  // What an operator can do without comes last: eighty columns show the rest.
  static constexpr std::array kColumns = {Column{.name = "TARGET", .least = 16},
                                          Column{.name = "VERSION", .rank = 6},
                                          Column{.name = "CONNECTION"},
                                          Column{.name = "SINCE", .rank = 7},
                                          Column{.name = "MODE", .rank = 3, .least = 10},
                                          Column{.name = "DRIVING", .rank = 5},
                                          Column{.name = "PAUSED", .rank = 1},
                                          Column{.name = "BATTERY", .rank = 2},
                                          Column{.name = "ORDER", .rank = 4, .least = 12},
                                          Column{.name = "ERRORS"}};
  return kColumns;
}

Row FleetRow(const ListedRobot& robot, base::WallTime now) {
  const RobotEntry& entry = robot.second;
  return {Target(robot), FormatVersion(entry), Connection(entry), Since(entry, now),
          Mode(entry),   Driving(entry),       Paused(entry),     Battery(entry),
          Order(entry),  Errors(entry)};
}

std::string FleetLine(const ListedRobot& robot, const Output& output) {
  const RobotEntry& entry = robot.second;
  const Cell connection = Connection(entry);
  const Cell errors = Errors(entry);
  return fmt::format("{}  {}  {}  {}  driving {}  paused {}  battery {}  order {}  errors {}",
                     Target(robot).text, FormatVersion(entry).text,
                     output.Toned(connection.tone, connection.text), Mode(entry).text,
                     Driving(entry).text, Paused(entry).text, Battery(entry).text,
                     Order(entry).text, output.Toned(errors.tone, errors.text));
}

std::string FleetJson(const ListedRobot& robot) {
  const auto& [address, entry] = robot;
  const std::string_view version =
      entry.own ? vda5050::GetFacts(entry.own->version).name : std::string_view();
  const vda5050::ConnectionMessage connection =
      entry.connection.value_or(vda5050::ConnectionMessage{});
  const std::size_t left_out = entry.state ? entry.state->errors_left_out : 0;
  return fmt::format(
             R"("target":{},"manufacturer":{},"serialNumber":{},"version":{},"headerVersion":{},)"
             R"("interface":{},"topicLevel":{},"connectionState":{},"connectionTimestamp":{},{})",
             JsonString(address.ToString()), JsonString(address.manufacturer),
             JsonString(address.serial_number), TextOrNull(version), TextOrNull(entry.said_version),
             TextOrNull(entry.InterfaceName()), TextOrNull(entry.TopicLevel()),
             TextOrNull(connection.connection_state), TextOrNull(connection.header.timestamp),
             StateJson(entry.state.get())) +
         (left_out == 0 ? "" : fmt::format(R"(,"errorsLeftOut":{})", left_out)) +
         TextMember(R"(,"stateFault":)", entry.state_fault) +
         TextMember(R"(,"connectionFault":)", connection.fault) +
         TextMember(R"(,"alsoAt":)", entry.AlsoAt());
}

std::string AgeText(std::chrono::nanoseconds age) {
  struct Unit {
    std::chrono::seconds length;
    const char* name;
  };
  constexpr std::array kUnits = {Unit{std::chrono::days(1), "d"}, Unit{std::chrono::hours(1), "h"},
                                 Unit{std::chrono::minutes(1), "min"}};
  for (const auto& [length, name] : kUnits) {
    if (age >= length) return fmt::format("{} {}", age / length, name);
  }
  return fmt::format("{} s", age / std::chrono::seconds(1));
}

}  // namespace fleetpub::cli
