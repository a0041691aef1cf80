// Robots on a screen through which a person moves with keys: a table that scrolls and filters, and
// one robot at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time.h"
#include "cli/output/output.h"
#include "cli/output/screen.h"
#include "cli/output/table.h"
#include "vda5050/reports/robot_directory.h"

namespace fleetpub::cli {

class FleetBrowser {
 public:
  using Robots = std::vector<const vda5050::ListedRobot*>;
  /// Since the robot last sent a state; nothing: that is not known.
  using Silence =
      std::function<std::optional<std::chrono::nanoseconds>(const vda5050::RobotAddress& robot)>;

  explicit FleetBrowser(const Output& output) : output_(output) {}

  /// What a key asks for, besides what the browser does itself.
  enum class Wish { kNothing, kQuit, kAsk };
  [[nodiscard]] Wish Press(int key);

  struct Frame {
    Screen::Size size;
    base::WallTime now;
    std::string title;    ///< behind the count of robots and the keys
    std::string trouble;  ///< "": none
  };
  /// The screen's lines; `robots` in the order in which they are shown.
  [[nodiscard]] std::vector<std::string> Lines(const Robots& robots, const Frame& frame,
                                               const Silence& silence);

  /// Those that the last lines were about, be they beyond the window.
  [[nodiscard]] const std::vector<vda5050::RobotAddress>& shown() const { return shown_; }

 private:
  enum class Mode { kTable, kFilter, kRobot, kKeys };

  void Type(int key);
  void Move(int key);
  void MoveTo(std::size_t row);
  void Leave();
  void Filter(Robots& robots, base::WallTime now) const;
  [[nodiscard]] std::optional<std::size_t> FindSelected() const;
  [[nodiscard]] std::vector<std::string> FormatTable(const Robots& robots, const Frame& frame,
                                                     const Silence& silence);
  [[nodiscard]] std::vector<std::string> Page(std::vector<std::string> lines,
                                              std::string_view title, const Frame& frame);

  const Output& output_;
  Mode mode_ = Mode::kTable;
  std::string filter_;
  std::optional<vda5050::RobotAddress> selected_;
  std::vector<vda5050::RobotAddress> shown_;
  std::size_t top_ = 0;   // the first row in the window
  std::size_t room_ = 1;  // rows in the window
  std::size_t line_ = 0;  // the first line of a page in the window
  std::size_t columns_ = 0;
  std::vector<std::size_t> widths_;  // of the table, which only grow until the window changes
};

}  // namespace fleetpub::cli
