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
constexpr std::size_t kLongestSentence = 200;
constexpr double kLowBattery = 20;
// Each robot repeats its state every 30 s.
constexpr std::chrono::seconds kStale{35};

std::string TextOr(std::string_view text, std::string_view otherwise) {
  return text.empty() ? std::string(otherwise) : Shown(text, kLongestText);
}

Cell Target(const ListedRobot& robot) { return {base::Printable(robot.first.ToString())}; }

Cell FormatVersion(const RobotEntry& robot) {
  if (robot.own) return {std::string(vda5050::GetFacts(robot.own->version).name)};
  return {TextOr(robot.said_version, kUnknown)};
}

// It is not there, and nothing but what it left tells of it.
bool IsLeftover(const RobotEntry& robot) { return !robot.IsAlive() && !robot.state; }

Cell Connection(const RobotEntry& robot) {
  if (!robot.connection) return {std::string(kUnknown)};
  if (!robot.connection->fault.empty()) return {"not readable", Tone::kBad};
  const std::string& said = robot.connection->connection_state;
  const bool is_broken = said == "CONNECTION_BROKEN";
  const Tone tone = said.empty()                      ? Tone::kPlain
                    : robot.IsOnline()                ? Tone::kGood
                    : IsLeftover(robot) && !is_broken ? Tone::kDim
                                                      : Tone::kBad;
  return {TextOr(said, kUnknown), tone};
}

// As short as a column is.
Cell ShortConnection(const RobotEntry& robot) {
  Cell cell = Connection(robot);
  if (cell.text == "CONNECTION_BROKEN") cell.text = "BROKEN";
  return cell;
}

std::string Ago(base::WallTime time, base::WallTime now) {
  return AgeText(std::max(now - time, std::chrono::system_clock::duration::zero()));
}

// A last will says when the robot connected, not when it broke.
Cell Since(const RobotEntry& robot, base::WallTime now) {
  if (!robot.connection || robot.connection->connection_state == "CONNECTION_BROKEN") {
    return {std::string(kUnknown)};
  }
  const auto time = vda5050::ReadTime(robot.connection->header);
  return {time ? Ago(*time, now) : std::string(kUnknown)};
}

Cell Mode(const RobotEntry& robot) {
  const std::string mode = robot.state ? robot.state->operating_mode : "";
  const bool is_usual = mode.empty() || mode == "AUTOMATIC";
  return {TextOr(mode, kUnknown), is_usual ? Tone::kPlain : Tone::kWarn};
}

Cell Safety(const RobotEntry& robot) {
  if (!robot.state) return {std::string(kUnknown)};
  const auto& field = robot.state->field_violation;
  if (vda5050::IsEmergencyStopped(*robot.state)) return {"E-STOP", Tone::kBad};
  if (field == true) return {"FIELD", Tone::kBad};
  return {robot.state->emergency_stop.empty() && !field ? std::string(kUnknown) : "ok"};
}

std::string YesNo(const std::optional<bool>& value) {
  return !value ? std::string(kUnknown) : *value ? "yes" : "no";
}

Cell Driving(const RobotEntry& robot) {
  return {YesNo(robot.state ? robot.state->driving : std::nullopt)};
}

Cell Paused(const RobotEntry& robot) {
  const auto paused = robot.state ? robot.state->paused : std::nullopt;
  return {YesNo(paused), paused == true ? Tone::kWarn : Tone::kPlain};
}

Cell Battery(const RobotEntry& robot, std::string_view charging) {
  const auto charge = robot.state ? robot.state->battery_charge : std::nullopt;
  std::string text = charge ? fmt::format("{:.0f}%", *charge) : std::string(kUnknown);
  if (robot.state && robot.state->charging == true) text += charging;
  return {text, charge && *charge < kLowBattery ? Tone::kWarn : Tone::kPlain};
}

Cell Order(const RobotEntry& robot) {
  return {robot.state ? TextOr(robot.state->order_id, "none") : std::string(kUnknown)};
}

// `motorFault: the left wheel is stuck`.
std::string FormatWorst(const vda5050::RobotError& error) {
  if (error.description.empty()) return Shown(error.type, kLongestText);
  return fmt::format("{}{}{}", Shown(error.type, kLongestText), error.type.empty() ? "" : ": ",
                     Shown(error.description, kLongestSentence));
}

Cell Errors(const RobotEntry& robot) {
  if (!robot.state_fault.empty()) return {"its state cannot be read", Tone::kBad};
  if (!robot.state) return {std::string(kUnknown)};
  const vda5050::RobotError* worst = vda5050::WorstError(robot.state->errors);
  if (worst == nullptr) return {"0"};
  const std::size_t count = robot.state->errors.size() + robot.state->errors_left_out;
  const std::string text = FormatWorst(*worst);
  return {fmt::format("{} {}{}{}{}", count, TextOr(worst->level, kUnknown),
                      vda5050::IsInstantActionListFull(robot.state->errors) ? ", list full" : "",
                      text.empty() ? "" : " ", text),
          worst->level == "WARNING" ? Tone::kWarn : Tone::kBad};
}

// The errors, or why nobody knows them.
Cell ErrorsOrAge(const RobotEntry& robot, base::WallTime now,
                 std::optional<std::chrono::nanoseconds> silence) {
  if (IsLeftover(robot) && robot.state_fault.empty() && robot.last_said) {
    const bool is_broken =
        robot.connection && robot.connection->connection_state == "CONNECTION_BROKEN";
    return {fmt::format("{} {} ago{}", is_broken ? "connected" : "last seen",
                        Ago(*robot.last_said, now), is_broken ? ", then lost" : ""),
            Tone::kDim};
  }
  Cell errors = Errors(robot);
  if (!silence || *silence < kStale || !robot.IsAlive()) return errors;
  return {fmt::format("silent for {}; {}", AgeText(*silence), errors.text),
          errors.tone == Tone::kBad ? Tone::kBad : Tone::kWarn};
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
           R"("charging":null,"orderId":null,"safety":null,"errors":null)";
  }
  return fmt::format(
             R"("operatingMode":{},"driving":{},"paused":{},"batteryCharge":{},"charging":{},)"
             R"("orderId":{},"safety":{{"emergencyStop":{},"fieldViolation":{}}},"errors":{})",
             TextOrNull(state->operating_mode), TruthOrNull(state->driving),
             TruthOrNull(state->paused), NumberOrUnknown(state->battery_charge),
             TruthOrNull(state->charging), JsonString(state->order_id),
             TextOrNull(state->emergency_stop), TruthOrNull(state->field_violation),
             ErrorsJson(state->errors)) +
         (vda5050::IsInstantActionListFull(state->errors) ? R"(,"instantActionsFull":true)" : "");
}

}  // namespace

std::span<const Column> FleetColumns() {
  // What an operator can do without goes first: eighty columns show the rest.
  static constexpr std::array kColumns = {Column{.name = "TARGET", .least = 14},
                                          Column{.name = "VERSION", .rank = 6},
                                          Column{.name = "CONNECTION"},
                                          Column{.name = "SINCE", .rank = 7},
                                          Column{.name = "MODE", .rank = 3, .least = 9},
                                          Column{.name = "SAFETY"},
                                          Column{.name = "DRIVING", .rank = 5},
                                          Column{.name = "PAUSED", .rank = 1},
                                          Column{.name = "BATTERY", .rank = 2},
                                          Column{.name = "ORDER", .rank = 4, .least = 12},
                                          Column{.name = "ERRORS", .least = 15}};
  return kColumns;
}

Row FleetRow(const ListedRobot& robot, base::WallTime now,
             std::optional<std::chrono::nanoseconds> silence) {
  const RobotEntry& entry = robot.second;
  return {Target(robot),
          FormatVersion(entry),
          ShortConnection(entry),
          Since(entry, now),
          Mode(entry),
          Safety(entry),
          Driving(entry),
          Paused(entry),
          Battery(entry, " chg"),
          Order(entry),
          ErrorsOrAge(entry, now, silence)};
}

std::string FleetLine(const ListedRobot& robot, const Output& output) {
  const RobotEntry& entry = robot.second;
  const Cell connection = Connection(entry);
  const Cell safety = Safety(entry);
  const Cell errors = Errors(entry);
  return fmt::format(
      "{}  {}  {}  {}  safety {}  driving {}  paused {}  battery {}  order {}  errors {}",
      Target(robot).text, FormatVersion(entry).text, output.Toned(connection.tone, connection.text),
      Mode(entry).text, output.Toned(safety.tone, safety.text), Driving(entry).text,
      Paused(entry).text, Battery(entry, " charging").text, Order(entry).text,
      output.Toned(errors.tone, errors.text));
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
         TextMember(R"(,"alsoAt":)", entry.AlsoAt()) +
         (entry.IsAlive() || !entry.last_said
              ? ""
              : TextMember(R"(,"lastSeen":)", base::FormatTimestamp(*entry.last_said)));
}

void SortRobots(std::vector<const ListedRobot*>& robots, SortBy by) {
  const auto sort = [&](const auto& key) {
    std::vector<std::pair<decltype(key(robots.front()->second)), const ListedRobot*>> keyed;
    keyed.reserve(robots.size());
    for (const ListedRobot* robot : robots) keyed.emplace_back(key(robot->second), robot);
    std::stable_sort(keyed.begin(), keyed.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::transform(keyed.begin(), keyed.end(), robots.begin(),
                   [](const auto& one) { return one.second; });
  };
  switch (by) {
    case SortBy::kName:
      return std::sort(
          robots.begin(), robots.end(),
          [](const ListedRobot* a, const ListedRobot* b) { return a->first < b->first; });
    case SortBy::kTrouble:
      return sort([](const RobotEntry& robot) {
        return std::pair(-vda5050::WeighTrouble(robot), !robot.IsAlive());
      });
    case SortBy::kBattery:
      return sort([](const RobotEntry& robot) {
        constexpr double kLast = 1e9;  // those of whom nothing is known
        return robot.state ? robot.state->battery_charge.value_or(kLast) : kLast;
      });
    case SortBy::kAge:
      return sort(
          [](const RobotEntry& robot) { return robot.last_said.value_or(base::WallTime::min()); });
  }
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
