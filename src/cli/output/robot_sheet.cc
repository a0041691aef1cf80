#include "cli/output/robot_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "base/width.h"
#include "cli/output/fleet_table.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/live_state.h"
#include "vda5050/reports/robot_errors.h"

namespace fleetpub::cli {
namespace {

using app::RobotSheet;
using vda5050::ActionState;
using vda5050::RobotState;
using vda5050::Shown;

constexpr std::string_view kNotSaid = "not said";
constexpr std::size_t kMostItems = 10;    // of a list that a robot may make as long as it likes
constexpr std::size_t kLongestName = 60;  // of what is a word or an id in messages that mean well

std::string Name(std::string_view text) { return Shown(text, kLongestName); }

std::string NameOr(std::string_view text, std::string_view otherwise) {
  return text.empty() ? std::string(otherwise) : Name(text);
}

// `1.5`, `-2`, `1200`: no more digits than anybody measures.
std::string FormatNumber(double number) {
  std::string text = fmt::format("{:.3f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

// Texts that are there, with a comma between them; without any, this one.
std::string JoinParts(std::vector<std::string> parts, std::string_view otherwise = kNotSaid) {
  std::erase(parts, "");
  return parts.empty() ? std::string(otherwise) : base::Join(parts, ", ");
}

std::string FormatIf(const std::optional<double>& number, std::string_view unit) {
  return number ? fmt::format("{} {}", FormatNumber(*number), unit) : "";
}

// In local time, with its age; as written where it cannot be read.
std::string FormatTime(const vda5050::MessageHeader& header, base::WallTime now) {
  const auto time = vda5050::ReadTime(header);
  if (!time) return NameOr(header.timestamp, "an unknown time");
  const auto age = std::max(now - *time, base::WallTime::duration::zero());
  return fmt::format("{} ({} ago)", base::FormatLocal(*time), AgeText(age));
}

std::string FormatReferences(const std::vector<vda5050::ErrorReference>& references) {
  std::vector<std::string> parts;
  for (const auto& [key, value] : references) {
    if (parts.size() == kMostItems) break;
    parts.push_back(fmt::format("{} {}", Name(key), Name(value)));
  }
  return parts.empty() ? "" : "; about " + base::Join(parts, ", ");
}

// Lines under one name each, the text in a column of its own.
class Sheet {
 public:
  Sheet(std::size_t width, const Output& output) : width_(width), output_(output) {}

  void AddTitle(std::string_view text) {
    for (std::string& line : base::Split(base::Wrapped(width_, 0, text), '\n')) {
      lines_.push_back(std::move(line));
    }
  }
  /// A name that is the last line's stands there once.
  void Add(std::string_view name, std::string_view text, Tone tone = Tone::kPlain) {
    std::string left = base::Padded(kColumn, fmt::format("  {}", name == last_ ? "" : name));
    last_ = name;
    const std::size_t room = width_ > kColumn + kLeast ? width_ - kColumn : kLeast;
    for (const std::string& line : base::Split(base::Wrapped(room, 0, text), '\n')) {
      lines_.push_back(std::exchange(left, std::string(kColumn, ' ')) + output_.Toned(tone, line));
    }
  }
  [[nodiscard]] std::vector<std::string> Take() { return std::move(lines_); }

 private:
  static constexpr std::size_t kColumn = 15;
  static constexpr std::size_t kLeast = 20;

  std::size_t width_;
  const Output& output_;
  std::string last_;
  std::vector<std::string> lines_;
};

std::pair<std::string, Tone> DescribeConnection(const RobotSheet& robot, base::WallTime now) {
  if (!robot.connection) {
    return {robot.speaks ? "no connection message, but it sends states" : "no connection message",
            Tone::kBad};
  }
  const auto& [header, state, fault] = *robot.connection;
  if (!fault.empty()) return {"not readable: " + fault, Tone::kBad};
  const bool is_online = state == "ONLINE";
  std::string text = NameOr(state, "not said");
  // A last will is dated when the robot connected, not when it broke.
  text += state == "CONNECTION_BROKEN" ? "; connected at " : " since ";
  text += FormatTime(header, now);
  if (!is_online && robot.speaks) text += "; but it sends states";
  return {text, is_online ? Tone::kGood : Tone::kBad};
}

std::string DescribeVersion(const RobotSheet& robot) {
  const std::string place = robot.place.empty() ? "" : " at " + Name(robot.place);
  if (!robot.version && robot.said_version.empty()) return "not known";
  if (!robot.version) {
    return fmt::format("{}{}, which fleetpub does not speak", Name(robot.said_version), place);
  }
  const std::string_view name = vda5050::GetFacts(*robot.version).name;
  const bool differs = !robot.said_version.empty() && robot.said_version != name;
  return fmt::format("{}{}{}", name, place,
                     differs ? fmt::format("; its header says {}", Name(robot.said_version)) : "");
}

// Why nothing is known of how the robot is.
std::string DescribeSilence(const RobotSheet& robot) {
  if (!robot.state_fault.empty()) {
    return "not known: its state cannot be read: " + Shown(robot.state_fault);
  }
  if (!robot.is_alive) return "not known: it is offline and left none";
  if (robot.is_recorded) return "not known: the recording has none";
  if (robot.is_watched) return "not known yet: a robot repeats it at least every 30 s";
  return fmt::format(
      "not known: none came within {}; a robot repeats it at least every 30 s: --state-wait 35s "
      "waits for it",
      base::FormatElapsed(robot.waited));
}

std::pair<std::string, Tone> DescribeMode(const std::string& mode) {
  const bool is_usual = mode == "AUTOMATIC" || mode == "SEMIAUTOMATIC";
  return {NameOr(mode, kNotSaid), is_usual ? Tone::kPlain : Tone::kBad};
}

std::pair<std::string, Tone> DescribeSafety(const RobotState& state) {
  const std::string stop = state.emergency_stop.empty() ? "emergency stop not reported"
                           : state.emergency_stop == "NONE"
                               ? "no emergency stop"
                               : "EMERGENCY STOP " + Name(state.emergency_stop);
  const std::string_view field = !state.field_violation   ? "field violation not reported"
                                 : *state.field_violation ? "FIELD VIOLATION"
                                                          : "no field violation";
  const bool is_stopped = !state.emergency_stop.empty() && state.emergency_stop != "NONE";
  return {fmt::format("{}, {}", stop, field),
          is_stopped || state.field_violation == true ? Tone::kBad : Tone::kPlain};
}

std::string DescribePosition(const RobotState& state) {
  std::string text(kNotSaid);
  if (const auto& position = state.position) {
    const auto number = [](const std::optional<double>& value) {
      return value ? FormatNumber(*value) : std::string("?");
    };
    text = fmt::format("x {}, y {}, theta {} on map {}", number(position->x), number(position->y),
                       number(position->theta), NameOr(position->map_id, "?"));
    if (position->localized == false) text += ", not localized";
  }
  return fmt::format("{}; last node {}", text, NameOr(state.last_node_id, "none"));
}

// Nodes have the even sequence ids, from 0 (1.1–2.1 §6.6, 3.0 §6.1).
std::string DescribeProgress(const RobotState& state) {
  if (!state.nodes_left) return "progress not said";
  if (*state.nodes_left + state.edges_left.value_or(0) == 0) return "nothing left of it";
  const auto last =
      std::max_element(state.nodes.begin(), state.nodes.end(),
                       [](const auto& a, const auto& b) { return a.sequence_id < b.sequence_id; });
  if (last == state.nodes.end() || !state.last_node_sequence_id ||
      *state.last_node_sequence_id > last->sequence_id) {
    return base::Counted(*state.nodes_left, "node") + " to go";
  }
  return fmt::format("node {} of {}", *state.last_node_sequence_id / 2 + 1,
                     last->sequence_id / 2 + 1);
}

std::string DescribeOrder(const RobotState& state) {
  if (state.order_id.empty()) return fmt::format("none, {}", vda5050::DescribeMotion(state));
  const std::string update =
      state.order_update_id ? fmt::format(" update {}", *state.order_update_id) : "";
  return fmt::format("{}{}: {}, {}", Name(state.order_id), update, DescribeProgress(state),
                     vda5050::DescribeMotion(state));
}

// Those that have not ended: what runs, then what waits.
std::vector<const ActionState*> ListOpenActions(const RobotState& state) {
  std::vector<const ActionState*> open;
  for (const auto* list :
       {&state.action_states, &state.instant_action_states, &state.zone_action_states}) {
    for (const ActionState& action : *list) {
      if (!vda5050::IsTerminal(action.status)) open.push_back(&action);
    }
  }
  std::stable_partition(open.begin(), open.end(),
                        [](const ActionState* action) { return action->status != "WAITING"; });
  return open;
}

void AddMore(Sheet& sheet, std::string_view name, std::size_t count) {
  if (count > kMostItems) sheet.Add(name, fmt::format("and {} more", count - kMostItems));
}

void AddActions(const RobotState& state, Extent extent, Sheet& sheet) {
  constexpr std::string_view kName = "actions";
  const auto open = ListOpenActions(state);
  if (open.empty() && extent == Extent::kWhole) sheet.Add(kName, "none running or waiting");
  for (std::size_t i = 0; i < std::min(open.size(), kMostItems); ++i) {
    const ActionState& action = *open[i];
    sheet.Add(kName,
              fmt::format("{} {} {}{}", NameOr(action.status, "status not said"),
                          NameOr(action.type, "action"), Name(action.id),
                          action.result.empty() ? "" : ": " + Shown(action.result)),
              action.status == "RETRIABLE" ? Tone::kBad : Tone::kPlain);
  }
  AddMore(sheet, kName, open.size());
}

void AddErrors(std::vector<vda5050::RobotError> errors, Extent extent, Sheet& sheet) {
  constexpr std::string_view kName = "errors";
  const std::size_t count = errors.size();
  if (count == 0 && extent == Extent::kWhole) sheet.Add(kName, "none");
  for (std::size_t i = 0; i < std::min(count, kMostItems); ++i) {
    const vda5050::RobotError* const worst = vda5050::WorstError(errors);
    sheet.Add(kName,
              fmt::format("{} {}{}", NameOr(worst->level, "level not said"),
                          vda5050::FormatError(*worst), FormatReferences(worst->references)),
              Tone::kBad);
    errors.erase(errors.begin() + (worst - errors.data()));
  }
  AddMore(sheet, kName, count);
}

void AddLoads(const RobotState& state, Sheet& sheet) {
  constexpr std::string_view kName = "loads";
  if (!state.loads) return sheet.Add(kName, kNotSaid);
  if (state.loads->empty()) return sheet.Add(kName, "none");
  for (std::size_t i = 0; i < std::min(state.loads->size(), kMostItems); ++i) {
    const vda5050::RobotLoad& load = (*state.loads)[i];
    sheet.Add(kName, JoinParts({Name(load.id), Name(load.type),
                                load.position.empty() ? "" : "at " + Name(load.position),
                                FormatIf(load.weight, "kg")},
                               "one without details"));
  }
  AddMore(sheet, kName, state.loads->size());
}

std::pair<std::string, Tone> DescribeBattery(const RobotState& state) {
  constexpr double kLow = 20;
  const auto part = [](const std::optional<double>& number, std::string_view before,
                       std::string_view unit) {
    return number ? std::string(before) + FormatIf(number, unit) : "";
  };
  const std::string_view charging = !state.charging   ? "charging not said"
                                    : *state.charging ? "charging"
                                                      : "not charging";
  const bool is_low = state.battery_charge && *state.battery_charge < kLow;
  return {JoinParts({state.battery_charge ? FormatIf(state.battery_charge, "%") : "charge not said",
                     std::string(charging), FormatIf(state.battery_voltage, "V"),
                     part(state.range, "range ", "m"), part(state.battery_health, "health ", "%")}),
          is_low && state.charging != true ? Tone::kBad : Tone::kPlain};
}

void AddInformation(const RobotState& state, Sheet& sheet) {
  constexpr std::string_view kName = "information";
  for (std::size_t i = 0; i < std::min(state.information.size(), kMostItems); ++i) {
    const auto& [type, level, description, references] = state.information[i];
    sheet.Add(kName,
              fmt::format("{} {}{}{}", NameOr(level, "level not said"), NameOr(type, "information"),
                          description.empty() ? "" : ": " + Shown(description),
                          FormatReferences(references)),
              Tone::kDim);
  }
  if (state.information.empty()) sheet.Add(kName, "none");
  AddMore(sheet, kName, state.information.size());
}

std::string DescribeSize(const vda5050::RobotSpecification& robot) {
  if (!robot.length && !robot.width && !robot.maximum_height) return "";
  const auto number = [](const std::optional<double>& value) {
    return value ? FormatNumber(*value) : std::string("?");
  };
  return fmt::format("{} x {} x {} m", number(robot.length), number(robot.width),
                     number(robot.maximum_height));
}

// Those that are not there.
std::vector<std::string> Without(std::vector<std::string> types,
                                 const std::vector<std::string>& others) {
  std::erase_if(types, [&](const std::string& type) {
    return std::find(others.begin(), others.end(), type) != others.end();
  });
  return types;
}

std::string ListNames(std::vector<std::string> types) {
  constexpr std::size_t kMost = 30;
  const std::size_t left_out = types.size() - std::min(types.size(), kMost);
  types.resize(types.size() - left_out);
  for (std::string& type : types) type = Name(type);
  if (left_out > 0) types.push_back(fmt::format("{} more", left_out));
  return base::Join(types, ", ");
}

// Nobody needs to read the twenty-four that most robots of a version have.
std::string DescribeAbilities(const RobotSheet& robot) {
  std::vector<std::string> listed;
  for (const auto& action : robot.factsheet->actions) listed.push_back(action.type);
  if (listed.empty()) return "actions not said";
  std::vector<std::string> predefined;
  if (robot.version) {
    for (const vda5050::ActionSpec* action : vda5050::ListActions(*robot.version)) {
      if (action->scopes.instant) predefined.emplace_back(action->type);
    }
  }
  const auto missing = Without(predefined, listed);
  const auto others = Without(listed, predefined);
  if (2 * missing.size() >= predefined.size()) return "actions: " + ListNames(std::move(listed));
  return fmt::format("actions: all {} instant ones of {}{}{}", predefined.size(),
                     vda5050::GetFacts(*robot.version).name,
                     missing.empty() ? "" : " but " + ListNames(missing),
                     others.empty() ? "" : "; also " + ListNames(others));
}

void AddFactsheet(const RobotSheet& robot, Sheet& sheet) {
  constexpr std::string_view kName = "factsheet";
  if (robot.is_watched && !robot.factsheet) return;
  if (!robot.factsheet_fault.empty()) {
    return sheet.Add(kName, "not readable: " + Shown(robot.factsheet_fault), Tone::kBad);
  }
  if (!robot.factsheet) {
    const bool is_too_old = robot.version == vda5050::Version::k110;
    return sheet.Add(kName, is_too_old ? "none: 1.1 has none" : "none is known");
  }
  const vda5050::RobotSpecification& is = robot.factsheet->specification;
  const std::string description =
      is.series_description.empty() ? "" : "(" + Shown(is.series_description) + ")";
  sheet.Add(kName,
            JoinParts({JoinParts({Name(is.series)}, "series not said") +
                           (description.empty() ? "" : " " + description),
                       Name(is.robot_class),
                       is.maximum_load ? "carries " + FormatIf(is.maximum_load, "kg") : ""}));
  sheet.Add(kName, JoinParts({Name(is.kinematics), DescribeSize(is),
                              is.maximum_speed ? "up to " + FormatIf(is.maximum_speed, "m/s") : ""},
                             "kinematics and size not reported"));
  sheet.Add(kName, DescribeAbilities(robot));
}

void AddCommands(const RobotSheet& robot, Sheet& sheet) {
  constexpr std::string_view kName = "commands";
  if (robot.is_watched || robot.is_recorded) return;
  if (!robot.commands_fault.empty()) {
    return sheet.Add(kName, "not known: " + base::Printable(robot.commands_fault), Tone::kBad);
  }
  if (robot.commands.empty()) sheet.Add(kName, "none in this ledger");
  for (const ledger::Record& record : robot.commands) {
    std::vector<std::string> types;
    for (const auto& action : record.actions) types.push_back(Name(action.type));
    const std::string_view topic = record.topic;
    const bool is_elsewhere = record.broker != robot.broker;
    sheet.Add(kName,
              fmt::format(
                  "{} {} {}{}, by {}@{}{}", base::FormatLocal(record.recorded_at),
                  types.empty() ? Name(topic.substr(topic.rfind('/') + 1)) : base::Join(types, ","),
                  record.status, record.detail.empty() ? "" : ": " + Shown(record.detail),
                  Name(record.user), Name(record.host),
                  is_elsewhere ? " over " + base::Printable(record.broker) : ""));
  }
}

void AddState(const RobotSheet& robot, Extent extent, base::WallTime now, Sheet& sheet) {
  if (!robot.state) {
    const std::string unknown = DescribeSilence(robot);
    sheet.Add("state", unknown, robot.is_alive ? Tone::kBad : Tone::kPlain);
    if (extent == Extent::kWhole) {
      sheet.Add("",
                "so nothing is known of mode, safety, position, order, actions, errors, loads "
                "and battery");
    }
    return;
  }
  const RobotState& state = *robot.state;
  if (robot.state_is_retained) {
    sheet.Add("state", fmt::format("retained, from {}: how it was", FormatTime(state.header, now)),
              Tone::kBad);
  } else if (extent == Extent::kWhole) {
    sheet.Add("state", fmt::format("from {}", FormatTime(state.header, now)));
  }
  const auto show = [&](std::string_view name, const std::pair<std::string, Tone>& described) {
    sheet.Add(name, described.first, described.second);
  };
  show("mode", DescribeMode(state.operating_mode));
  show("safety", DescribeSafety(state));
  sheet.Add("position", DescribePosition(state));
  sheet.Add("order", DescribeOrder(state), state.paused == true ? Tone::kBad : Tone::kPlain);
  AddActions(state, extent, sheet);
  AddErrors(state.errors, extent, sheet);
  if (extent == Extent::kWhole) AddLoads(state, sheet);
  show("battery", DescribeBattery(state));
  if (extent == Extent::kWhole) AddInformation(state, sheet);
}

}  // namespace

std::vector<std::string> RobotSheetLines(const RobotSheet& sheet, Extent extent, std::size_t width,
                                         base::WallTime now, const Output& output) {
  Sheet lines(width, output);
  lines.AddTitle(base::Printable(sheet.robot.ToString()));
  const auto [connection, tone] = DescribeConnection(sheet, now);
  lines.Add("connection", connection, tone);
  if (extent == Extent::kWhole) lines.Add("version", DescribeVersion(sheet));
  AddState(sheet, extent, now, lines);
  if (extent == Extent::kWhole) {
    AddFactsheet(sheet, lines);
    AddCommands(sheet, lines);
  }
  return lines.Take();
}

}  // namespace fleetpub::cli
