#include "message/command_status.h"

namespace fleetpub::message {

std::optional<ErrorKind> ToErrorKind(CommandStatus status) {
  switch (status) {
    case CommandStatus::kFailed:
    case CommandStatus::kRejected:
      return ErrorKind::kRejected;
    case CommandStatus::kRetriable:
    case CommandStatus::kVanished:
    case CommandStatus::kOffline:
    case CommandStatus::kTimeout:
      return ErrorKind::kUnconfirmed;
    default:
      return std::nullopt;
  }
}

}  // namespace fleetpub::message
