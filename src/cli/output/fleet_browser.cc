#include "cli/output/fleet_browser.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/text.h"
#include "base/width.h"
#include "cli/output/fleet_table.h"
#include "cli/output/robot_sheet.h"

namespace fleetpub::cli {
namespace {

using vda5050::ListedRobot;

std::string FormatTitle(const FleetBrowser::Robots& robots, const FleetBrowser::Frame& frame) {
  const auto count = [&](const auto& is) {
    return std::count_if(robots.begin(), robots.end(),
                         [&](const ListedRobot* robot) { return is(robot->second); });
  };
  const auto online = count([](const vda5050::RobotEntry& robot) { return robot.IsOnline(); });
  const auto troubled = count(vda5050::HasProblem);
  // What matters most comes first: a narrow window cuts the rest.
  return fmt::format("{}, {} online{}   q quits   ? keys   {}   {}",
                     base::Counted(robots.size(), "robot"), online,
                     troubled == 0 ? "" : fmt::format(", {} in trouble", troubled),
                     base::FormatLocal(frame.now), frame.title);
}

std::vector<std::string> DescribeKeys() {
  return {"arrows, j, k     up and down",
          "PgUp, PgDn       a page up and down",
          "g, G             to the first and to the last",
          "/                show only rows with a text; Esc clears it",
          "Enter            all that is known of the robot",
          "s                ask all shown robots for their state",
          "Esc, Backspace   back",
          "q                back, and from the table to the end",
          "?                these keys"};
}

}  // namespace

FleetBrowser::Wish FleetBrowser::Press(int key) {
  if (mode_ == Mode::kFilter) {
    Type(key);
    return Wish::kNothing;
  }
  switch (key) {
    case 'q':
    case 'Q':
      if (mode_ == Mode::kTable) return Wish::kQuit;
      [[fallthrough]];
    case kEscape:
    case kBackspace:
      Leave();
      return Wish::kNothing;
    case 's':
      return Wish::kAsk;
    case '?':
      mode_ = Mode::kKeys;
      line_ = 0;
      return Wish::kNothing;
    default:
      Move(key);
      return Wish::kNothing;
  }
}

// A level back.
void FleetBrowser::Leave() {
  if (std::exchange(mode_, Mode::kTable) != Mode::kTable) return;
  filter_.clear();
  selected_.reset();
}

void FleetBrowser::Type(int key) {
  if (key == kEnter || key == kEscape) mode_ = Mode::kTable;
  if (key == kEscape) filter_.clear();
  if (key == kBackspace) {
    while (!filter_.empty() && (static_cast<unsigned char>(filter_.back()) & 0xC0U) == 0x80) {
      filter_.pop_back();
    }
    if (!filter_.empty()) filter_.pop_back();
  }
  if (key >= ' ' && key < 256 && key != kBackspace) filter_ += static_cast<char>(key);
}

std::optional<std::size_t> FleetBrowser::FindSelected() const {
  if (!selected_) return std::nullopt;
  const auto found = std::find(shown_.begin(), shown_.end(), *selected_);
  if (found == shown_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - shown_.begin());
}

void FleetBrowser::MoveTo(std::size_t row) {
  if (shown_.empty()) return;
  row = std::min(row, shown_.size() - 1);
  selected_ = shown_[row];
  top_ = std::clamp(top_, row + 1 - std::min(row + 1, room_), row);
}

void FleetBrowser::Move(int key) {
  const bool is_table = mode_ == Mode::kTable;
  if (is_table && key == '/') {
    mode_ = Mode::kFilter;
    return;
  }
  const auto selected = FindSelected();
  if (is_table && key == kEnter) {
    MoveTo(selected.value_or(top_));
    if (selected_) mode_ = Mode::kRobot;
    line_ = 0;
    return;
  }
  // The first step marks a row where the window is.
  const std::size_t at = is_table ? selected.value_or(top_) : line_;
  const std::size_t page = std::max<std::size_t>(room_, 1);
  const std::size_t step = is_table && !selected ? 0 : 1;
  std::size_t to = at;
  if (key == kUp || key == 'k')
    to = at - std::min(at, step);
  else if (key == kDown || key == 'j')
    to = at + step;
  else if (key == kPageUp)
    to = at - std::min(at, page);
  else if (key == kPageDown)
    to = at + page;
  else if (key == kHome || key == 'g')
    to = 0;
  else if (key == kEnd || key == 'G')
    to = SIZE_MAX / 2;
  else
    return;
  if (is_table) {
    MoveTo(to);
  } else {
    line_ = to;
  }
}

// Those in whose rows the text is, letter case aside.
void FleetBrowser::Filter(Robots& robots, base::WallTime now) const {
  const std::string wanted = base::ToLower(filter_);
  std::erase_if(robots, [&](const ListedRobot* robot) {
    std::string text;
    for (const Cell& cell : FleetRow(*robot, now)) text += cell.text + "  ";
    return base::ToLower(text).find(wanted) == std::string::npos;
  });
}

std::vector<std::string> FleetBrowser::Lines(const Robots& robots, const Frame& frame,
                                             const Silence& silence) {
  if (std::exchange(columns_, frame.size.columns) != frame.size.columns) widths_.clear();
  Robots some = robots;
  if (!filter_.empty()) Filter(some, frame.now);
  shown_.clear();
  for (const ListedRobot* robot : some) shown_.push_back(robot->first);
  std::vector<std::string> lines;
  const auto chosen = std::find_if(robots.begin(), robots.end(), [&](const ListedRobot* robot) {
    return selected_ && robot->first == *selected_;
  });
  if (mode_ == Mode::kRobot && chosen == robots.end()) mode_ = Mode::kTable;
  if (mode_ == Mode::kRobot) {
    app::RobotSheet sheet = app::MakeRobotSheet(**chosen);
    sheet.is_watched = true;
    lines = Page(RobotSheetLines(sheet, Extent::kWhole, columns_, frame.now, output_),
                 base::Printable((*chosen)->first.ToString()) + "   Esc comes back   " +
                     base::FormatLocal(frame.now),
                 frame);
  } else if (mode_ == Mode::kKeys) {
    lines = Page(DescribeKeys(), "Keys   Esc comes back", frame);
  } else {
    lines = FormatTable(some, frame, silence);
    lines.insert(lines.begin(), base::Shortened(columns_, FormatTitle(robots, frame)));
  }
  lines.resize(std::min(lines.size(), frame.size.rows));
  return lines;
}

std::vector<std::string> FleetBrowser::FormatTable(const Robots& robots, const Frame& frame,
                                                   const Silence& silence) {
  constexpr std::size_t kAround = 3;  // title, trouble, the table's header
  room_ = frame.size.rows - std::min(frame.size.rows, kAround);
  const bool all_fit = robots.size() <= room_;
  if (!all_fit && room_ > 0) --room_;
  top_ = std::min(top_, robots.size() - std::min(robots.size(), room_));
  const auto selected = FindSelected();
  if (selected) MoveTo(*selected);
  const std::size_t end = std::min(robots.size(), top_ + room_);
  std::vector<Row> rows;
  for (std::size_t i = top_; i < end; ++i) {
    rows.push_back(FleetRow(*robots[i], frame.now, silence(robots[i]->first)));
  }
  if (selected && *selected >= top_ && *selected < end) {
    for (Cell& cell : rows[*selected - top_]) cell.tone = Tone::kPlain;
  }
  const auto line = [&](Tone tone, std::string_view text) {
    return output_.Toned(tone, base::Shortened(columns_, text));
  };
  std::vector<std::string> lines;
  const bool is_typed = mode_ == Mode::kFilter;
  if (is_typed || !filter_.empty()) {
    lines.push_back(
        line(Tone::kWarn, fmt::format("/{}{}   {} of them   {}", base::Printable(filter_),
                                      is_typed ? "_" : "", robots.size(), "Esc clears")));
  } else {
    lines.push_back(line(Tone::kBad, frame.trouble));
  }
  auto body = TableLines(FleetColumns(), rows, columns_, output_, &widths_);
  if (selected && *selected >= top_ && *selected < end) {
    std::string& row = body[*selected - top_ + 1];
    row = "\x1b[7m" + base::Padded(columns_, row) + "\x1b[0m";
  }
  lines.insert(lines.end(), body.begin(), body.end());
  if (!all_fit) {
    lines.push_back(line(Tone::kDim, fmt::format("{} to {} of {}: arrows, PgUp and PgDn scroll",
                                                 top_ + 1, end, robots.size())));
  }
  return lines;
}

// Lines that scroll, below a title.
std::vector<std::string> FleetBrowser::Page(std::vector<std::string> lines, std::string_view title,
                                            const Frame& frame) {
  room_ = frame.size.rows - std::min<std::size_t>(frame.size.rows, 2);
  line_ = std::min(line_, lines.size() - std::min(lines.size(), room_));
  std::vector<std::string> page = {base::Shortened(columns_, title), ""};
  for (std::size_t i = line_; i < std::min(lines.size(), line_ + room_); ++i) {
    page.push_back(std::move(lines[i]));
  }
  return page;
}

}  // namespace fleetpub::cli
