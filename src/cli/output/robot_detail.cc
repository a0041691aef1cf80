#include "cli/output/robot_detail.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "base/width.h"
#include "cli/output/fleet_table.h"

namespace fleetpub::cli {
namespace {

using vda5050::LiveState;
using vda5050::RobotEntry;
using vda5050::Shown;

class Writer {
 public:
  Writer(const vda5050::ListedRobot& robot, base::WallTime now, std::size_t width,
         const Output& output)
      : robot_(robot.second), row_(FleetRow(robot, now)), width_(width), output_(output) {}

  std::vector<std::string> Write(std::optional<std::chrono::nanoseconds> silence) {
    WriteConnection();
    if (!robot_.state_fault.empty()) {
      Add("state", {"cannot be read: " + Shown(robot_.state_fault), Tone::kBad});
    }
    if (!robot_.state) {
      Add("state", {"none was heard: a robot repeats it every 30 s", Tone::kDim});
      return std::move(lines_);
    }
    if (silence) Add("state", {AgeText(*silence) + " old"});
    const LiveState& state = *robot_.state;
    WriteBearing(state);
    WriteOrder(state);
    WriteActions(state);
    WriteErrors(state);
    return std::move(lines_);
  }

 private:
  void Add(std::string_view name, const Cell& cell) {
    if (cell.text.empty() || cell.text == "-") return;
    std::string label = base::Shortened(width_, fmt::format("{:<12} ", name));
    const std::size_t room = width_ - std::min(width_, base::MeasureWidth(label));
    for (std::string_view rest = cell.text; !rest.empty();) {
      const std::string_view part = base::CutTo(room, rest);
      if (part.empty()) break;
      lines_.push_back(label + output_.Toned(cell.tone, part));
      rest.remove_prefix(part.size());
      label.assign(label.size(), ' ');
    }
  }
  // What its row has under this name.
  void AddColumn(std::string_view name, std::string_view column) {
    const auto columns = FleetColumns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].name == column) Add(name, row_[i]);
    }
  }

  void WriteConnection() {
    if (robot_.connection) {
      Add("connection", {vda5050::ConnectionText(*robot_.connection),
                         robot_.IsOnline() ? Tone::kGood : Tone::kBad});
    }
    AddColumn("version", "VERSION");
    Add("topics", {base::Printable(robot_.place)});
    if (!robot_.AlsoAt().empty()) {
      Add("also at", {base::Printable(robot_.AlsoAt()), Tone::kWarn});
    }
  }

  void WriteBearing(const LiveState& state) {
    AddColumn("mode", "MODE");
    AddColumn("paused", "PAUSED");
    AddColumn("driving", "DRIVING");
    AddColumn("safety", "SAFETY");
    if (vda5050::IsEmergencyStopped(state)) {
      Add("", {"acknowledge: " + Shown(state.emergency_stop), Tone::kBad});
    }
    AddColumn("battery", "BATTERY");
    if (const auto& at = state.position; at && at->x && at->y) {
      Add("position", {fmt::format("x {:.2f}  y {:.2f}{}{}{}", *at->x, *at->y,
                                   at->theta ? fmt::format("  theta {:.2f}", *at->theta) : "",
                                   at->map_id.empty() ? "" : "  map " + Shown(at->map_id),
                                   at->localized == false ? "  not localized" : ""),
                       at->localized == false ? Tone::kWarn : Tone::kPlain});
    }
  }

  void WriteOrder(const LiveState& state) {
    std::string order = state.order_id.empty() ? "none" : Shown(state.order_id);
    if (state.order_update_id && !state.order_id.empty()) {
      order += fmt::format("  update {}", *state.order_update_id);
    }
    if (state.nodes_left) order += fmt::format("  nodes to go {}", *state.nodes_left);
    Add("order", {order});
    if (!state.last_node_id.empty()) Add("last node", {Shown(state.last_node_id)});
    for (const vda5050::RobotRequest& request : state.requests) {
      Add("request",
          {fmt::format("{} {} {}", Shown(request.id), Shown(request.type), Shown(request.status))});
    }
  }

  void WriteActions(const LiveState& state) {
    for (const auto* list : {&state.instant_action_states, &state.action_states}) {
      for (const vda5050::ActionState& action : *list) {
        Add("action",
            {fmt::format("{} {}{}{}", action.type.empty() ? Shown(action.id) : Shown(action.type),
                         Shown(action.status), action.result.empty() ? "" : ": ",
                         Shown(action.result)),
             action.status == "FAILED" ? Tone::kBad : Tone::kPlain});
      }
    }
    if (state.is_slim) Add("actions", {"not kept: fewer TARGETs help", Tone::kDim});
  }

  void WriteErrors(const LiveState& state) {
    for (const vda5050::RobotError& error : state.errors) {
      const Tone tone = error.level == "WARNING" ? Tone::kWarn : Tone::kBad;
      Add(Shown(error.level, 12),
          {fmt::format("{}{}{}", Shown(error.type), error.description.empty() ? "" : ": ",
                       Shown(error.description)),
           tone});
      if (!error.hint.empty()) Add("", {"hint: " + Shown(error.hint)});
    }
    if (state.errors.empty()) Add("errors", {"none"});
    if (state.errors_left_out > 0) {
      Add("errors", {fmt::format("{} more are not kept", state.errors_left_out), Tone::kDim});
    }
  }

  const RobotEntry& robot_;
  Row row_;
  std::size_t width_;
  const Output& output_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> RobotLines(const vda5050::ListedRobot& robot, base::WallTime now,
                                    std::optional<std::chrono::nanoseconds> silence,
                                    std::size_t width, const Output& output) {
  return Writer(robot, now, width, output).Write(silence);
}

}  // namespace fleetpub::cli
