// What a report says.
#pragma once

#include <gmock/gmock.h>

#include <string>

#include "message/report.h"

namespace fleetpub::testing {

inline auto Is(message::CommandStatus status) {
  return ::testing::Field(&message::Report::status, status);
}
inline auto Says(const std::string& text) {
  return ::testing::Field(&message::Report::message, ::testing::HasSubstr(text));
}

}  // namespace fleetpub::testing
