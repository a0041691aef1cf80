#include "cli/output/fleet_metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "base/text.h"

namespace fleetpub::cli {
namespace {

using vda5050::ListedRobot;
using vda5050::LiveState;
using vda5050::RobotEntry;
using Write = std::function<void(std::string_view)>;
using Number = std::optional<double>;

// What robots may say freely is one of these, or OTHER: a hostile one must not fill a database with
// series.
constexpr auto kModes = std::to_array<std::string_view>(
    {"STARTUP", "AUTOMATIC", "SEMIAUTOMATIC", "INTERVENED", "MANUAL", "SERVICE", "TEACH_IN"});
constexpr auto kConnections =
    std::to_array<std::string_view>({"ONLINE", "OFFLINE", "HIBERNATING", "CONNECTION_BROKEN"});
constexpr auto kLevels =
    std::to_array<std::string_view>({"WARNING", "URGENT", "CRITICAL", "FATAL"});
constexpr std::string_view kOther = "OTHER";

std::string_view Known(std::string_view word, std::span<const std::string_view> words) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (found != words.end()) return *found;
  return word.empty() ? "UNKNOWN" : kOther;
}

// A label's value; hidden characters are made visible as everywhere.
std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : base::Printable(text)) {
    if (c == '\\' || c == '"') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string Label(const ListedRobot& robot) {
  return fmt::format(R"(robot="{}")", Escaped(robot.first.ToString()));
}

Number ToNumber(const std::optional<bool>& truth) {
  return truth ? Number(*truth ? 1 : 0) : std::nullopt;
}

Number ToNumber(const std::optional<std::size_t>& count) {
  return count ? Number(static_cast<double>(*count)) : std::nullopt;
}

// One value for each robot of which it is known.
struct Gauge {
  std::string_view name;
  std::string_view help;
  Number (*value)(const LiveState& state, base::WallTime now);
};
constexpr auto kGauges = std::to_array<Gauge>({
    {"fleetpub_robot_state_age_seconds", "Since the robot made its last state, by its own clock.",
     [](const LiveState& state, base::WallTime now) {
       const auto time = vda5050::ReadTime(state.header);
       if (!time) return Number();
       return Number(std::max(std::chrono::duration<double>(now - *time).count(), 0.0));
     }},
    {"fleetpub_robot_battery_charge_ratio", "Charge of the battery: 1 is full.",
     [](const LiveState& state, base::WallTime) {
       return state.battery_charge ? Number(*state.battery_charge / 100) : std::nullopt;
     }},
    {"fleetpub_robot_charging", "Whether the battery is charged.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.charging); }},
    {"fleetpub_robot_driving", "Whether the robot drives.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.driving); }},
    {"fleetpub_robot_paused", "Whether the robot is paused.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.paused); }},
    {"fleetpub_robot_emergency_stop", "Whether an emergency stop is active.",
     [](const LiveState& state, base::WallTime) {
       if (state.emergency_stop.empty()) return Number();
       return Number(vda5050::IsEmergencyStopped(state) ? 1 : 0);
     }},
    {"fleetpub_robot_field_violation", "Whether the protective field is violated.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.field_violation); }},
    {"fleetpub_robot_order_nodes_remaining", "Nodes of the order that lie ahead.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.nodes_left); }},
    {"fleetpub_robot_order_edges_remaining", "Edges of the order that lie ahead.",
     [](const LiveState& state, base::WallTime) { return ToNumber(state.edges_left); }},
});

class Writer {
 public:
  Writer(std::span<const ListedRobot* const> robots, const Write& write)
      : robots_(robots), write_(write) {}

  // `sample(robot, add)` calls add(labels, value) for each of the robot's samples.
  template <class Sample>
  void Family(std::string_view name, std::string_view help, const Sample& sample) {
    Describe(name, "gauge", help);
    for (const ListedRobot* robot : robots_) {
      sample(robot->second, [&](std::string_view labels, double value) {
        if (!std::isfinite(value)) return;
        write_(fmt::format("{}{{{}{}{}}} {}\n", name, Label(*robot), labels.empty() ? "" : ",",
                           labels, value));
      });
    }
  }

  void Describe(std::string_view name, std::string_view type, std::string_view help) {
    write_(fmt::format("# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help));
  }

 private:
  std::span<const ListedRobot* const> robots_;
  const Write& write_;
};

std::string Info(const ListedRobot& robot) {
  const auto& [address, entry] = robot;
  const std::string_view version =
      entry.own ? vda5050::GetFacts(entry.own->version).name : std::string_view();
  return fmt::format(R"({},manufacturer="{}",serial_number="{}",version="{}",interface="{}")",
                     Label(robot), Escaped(address.manufacturer), Escaped(address.serial_number),
                     version, Escaped(entry.InterfaceName()));
}

void WriteErrors(Writer& writer) {
  writer.Family("fleetpub_robot_errors", "Errors that the robot tells, by their level.",
                [](const RobotEntry& robot, const auto& add) {
                  if (!robot.state) return;
                  const auto& errors = robot.state->errors;
                  std::size_t others = errors.size() + robot.state->errors_left_out;
                  for (const std::string_view level : kLevels) {
                    const auto count =
                        std::count_if(errors.begin(), errors.end(),
                                      [&](const auto& error) { return error.level == level; });
                    others -= static_cast<std::size_t>(count);
                    add(fmt::format(R"(level="{}")", level), static_cast<double>(count));
                  }
                  add(fmt::format(R"(level="{}")", kOther), static_cast<double>(others));
                });
}

// By the nearest rank: a value that was measured.
double Quantile(const std::vector<double>& sorted, double quantile) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

void WriteTimes(const app::ConfirmTimes& times, Writer& writer, const Write& write) {
  constexpr std::string_view kName = "fleetpub_command_confirmation_seconds";
  writer.Describe(kName, "summary",
                  "From recording a command to the robot's own word that it is done, of the last "
                  "hour.");
  for (const auto& [topic, unsorted] : times) {
    std::vector<double> sorted = unsorted;
    std::sort(sorted.begin(), sorted.end());
    for (const double quantile : {0.5, 0.9, 0.99}) {
      write(fmt::format("{}{{topic=\"{}\",quantile=\"{}\"}} {}\n", kName, topic, quantile,
                        Quantile(sorted, quantile)));
    }
    write(fmt::format("{0}_sum{{topic=\"{1}\"}} {2}\n{0}_count{{topic=\"{1}\"}} {3}\n", kName,
                      topic, std::accumulate(sorted.begin(), sorted.end(), 0.0), sorted.size()));
  }
}

}  // namespace

void WriteFleetMetrics(std::span<const ListedRobot* const> robots, base::WallTime now,
                       const std::optional<app::ConfirmTimes>& times, const Write& write) {
  Writer writer(robots, write);
  writer.Describe("fleetpub_robot_info", "gauge", "Who the robot is, and what it speaks.");
  for (const ListedRobot* robot : robots) {
    write(fmt::format("fleetpub_robot_info{{{}}} 1\n", Info(*robot)));
  }
  writer.Family("fleetpub_robot_problem", "Whether somebody has to look after it (--problems).",
                [](const RobotEntry& robot, const auto& add) {
                  add("", vda5050::HasProblem(robot) ? 1 : 0);
                });
  writer.Family("fleetpub_robot_connection_state", "1 for what its connection message says.",
                [](const RobotEntry& robot, const auto& add) {
                  const std::string_view said =
                      robot.connection ? robot.connection->connection_state : std::string_view();
                  add(fmt::format(R"(state="{}")", Known(said, kConnections)), 1);
                });
  writer.Family("fleetpub_robot_operating_mode", "1 for the mode that the robot is in.",
                [](const RobotEntry& robot, const auto& add) {
                  if (!robot.state) return;
                  add(fmt::format(R"(mode="{}")", Known(robot.state->operating_mode, kModes)), 1);
                });
  WriteErrors(writer);
  for (const Gauge& gauge : kGauges) {
    writer.Family(gauge.name, gauge.help, [&](const RobotEntry& robot, const auto& add) {
      const Number value = robot.state ? gauge.value(*robot.state, now) : std::nullopt;
      if (value) add("", *value);
    });
  }
  if (times) WriteTimes(*times, writer, write);
  write("# EOF\n");
}

}  // namespace fleetpub::cli
