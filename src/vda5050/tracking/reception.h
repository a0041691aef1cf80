// What a tracker takes from the messages on its robot's topics, and what it passes over.
#pragma once

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.h"
#include "message/response_tracker.h"
#include "vda5050/messages/instant_actions.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::vda5050 {

/// A message that cannot be read, one whose header names another robot, and a state that was made
/// before one that has come already prove nothing.
class Reception {
 public:
  /// In a header the robot may call itself as its topic does, or as its dialect says.
  Reception(RobotAddress robot, const Dialect& dialect)
      : names_{std::move(robot), {dialect.header_manufacturer, dialect.header_serial}} {
    if (names_[1].manufacturer.empty()) names_[1].manufacturer = names_[0].manufacturer;
    if (names_[1].serial_number.empty()) names_[1].serial_number = names_[0].serial_number;
  }

  std::optional<RobotState> TakeState(const message::Incoming& message) {
    auto state = Take<RobotState>("state", message.payload, ReadState);
    if (!state || message.retained) return state;  // the past: no measure of others
    if (newest_ && IsBefore(state->header, *newest_)) return std::nullopt;
    newest_ = state->header;
    return state;
  }

  /// A robot that connects anew may count and date anew.
  std::optional<ConnectionMessage> TakeConnection(const message::Incoming& message) {
    auto connection =
        Take<ConnectionMessage>("connection message", message.payload, ReadConnection);
    if (connection && !message.retained) newest_.reset();
    return connection;
  }

  std::optional<Factsheet> TakeFactsheet(const message::Incoming& message) {
    return Take<Factsheet>("factsheet", message.payload, ReadFactsheet);
  }

  void PassOver(std::string_view topic_name, std::string_view why) {
    ++passed_over_;
    why_ = fmt::format("the last one, a {}: {}", topic_name, why);
  }
  void Forget() { passed_over_ = 0; }

  /// So many messages prove nothing though they may be the answer.
  [[nodiscard]] int passed_over() const { return passed_over_; }

  /// How many those are, and why; "" when all that came was taken. One line.
  [[nodiscard]] std::string Text() const {
    if (passed_over_ == 0) return "";
    return fmt::format("{} of its messages did not count; {}", passed_over_, why_);
  }

 private:
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

  std::array<RobotAddress, 2> names_;
  std::optional<MessageHeader> newest_;  // of the live states
  int passed_over_ = 0;
  std::string why_;
};

}  // namespace fleetpub::vda5050
