// What became of a command: the one shape that text, JSON, exit code and audit trail are made of.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "message/command.h"
#include "message/command_status.h"
#include "message/response_tracker.h"

namespace fleetpub::message {

struct Report {
  std::string reference;  ///< the command's
  std::string target;
  std::string protocol;
  std::string version;
  bool version_assumed = false;
  std::string topic;
  std::vector<ActionRef> actions;
  std::optional<std::uint32_t> header_id;  ///< none when nothing was stamped
  CommandStatus status = CommandStatus::kError;
  std::string message;  ///< why, when it is not a success; one line
  /// It left, or may have, but the broker did not say that it has it.
  bool unacknowledged = false;
  Kept kept = Kept::kNothing;
  /// Which kind of trouble, when there was some.
  std::optional<ErrorKind> error;
  std::string payload;          ///< as sent, or as it would be
  std::int64_t ledger_row = 0;  ///< where the audit trail has it; 0: nowhere
  std::chrono::nanoseconds elapsed{0};
};

/// A report with everything that the command already tells.
[[nodiscard]] Report ReportOn(const Command& command);

}  // namespace fleetpub::message
