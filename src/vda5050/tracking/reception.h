// What a tracker takes from the messages on its robot's topics, and what it passes over.
#pragma once

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// A message that cannot be read, and one whose header names another robot, confirm nothing.
class Reception {
 public:
  /// In a header the robot may call itself as its topic does, or as its dialect says.
  Reception(RobotAddress robot, const Dialect& dialect)
      : names_{std::move(robot), {dialect.header_manufacturer, dialect.header_serial}} {
    if (names_[1].manufacturer.empty()) names_[1].manufacturer = names_[0].manufacturer;
    if (names_[1].serial_number.empty()) names_[1].serial_number = names_[0].serial_number;
  }

  /// Nothing when the message is passed over. An empty one, with which a broker forgets a retained
  /// one, is none.
  template <typename Said>
  std::optional<Said> Take(std::string_view topic_name, std::string_view payload,
                           Result<Said> (*read)(std::string_view)) {
    if (payload.empty()) return std::nullopt;
    Result<Said> said = read(payload);
    if (!said) {
      PassOver(topic_name, said.error().message);
      return std::nullopt;
    }
    if (const std::string other = OtherSender(said->header, names_); !other.empty()) {
      PassOver(topic_name, fmt::format("its header names {}; if this robot calls itself so, "
                                       "say --header-manufacturer and --header-serial",
                                       other));
      return std::nullopt;
    }
    return *std::move(said);
  }

  void PassOver(std::string_view topic_name, std::string_view why) {
    passed_over_ = fmt::format("its last {} does not count: {}", topic_name, why);
  }
  void Forget() { passed_over_.clear(); }

  /// Which message confirmed nothing, and why; "" when all that came was taken. One line.
  [[nodiscard]] const std::string& passed_over() const { return passed_over_; }

 private:
  std::array<RobotAddress, 2> names_;
  std::string passed_over_;
};

}  // namespace fleetpub::vda5050
