// What a use case tells while it runs. Who called it decides what a person gets to see.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/result.h"
#include "message/report.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::app {

/// Sentences for people.
class Log {
 public:
  Log() = default;
  Log(const Log&) = default;
  Log& operator=(const Log&) = default;
  virtual ~Log() = default;

  virtual void Warn(std::string_view text) = 0;
  /// What happens meanwhile.
  virtual void Info(std::string_view text) = 0;
  virtual void Debug(std::string_view text) = 0;
};

}  // namespace fleetpub::app
