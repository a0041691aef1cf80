// The closed list of what can become of a command. The names stand in JSON, in the ledger and in
// the manual.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "base/result.h"

namespace fleetpub::message {

enum class CommandStatus {
  kDryRun,     ///< built and validated; nothing was sent
  kSent,       ///< handed to the operating system at QoS 0: a hope
  kPublished,  ///< acknowledged by the broker
  kAccepted,   ///< the target lists it and has not refused it
  kFinished,   ///< the target says that it is done
  kFailed,     ///< the target says that it failed
  kRejected,   ///< the target refused it
  kRetriable,  ///< neither done nor failed: it waits for retry, skipRetry or a person
  kVanished,   ///< the target had listed it and no longer does, without an end
  kOffline,    ///< the target lost its connection while we waited
  kTimeout,    ///< the target did not say in time
  kRefused,    ///< by us, before sending: unknown, offline, not supported
  kInvalid,    ///< breaks the specification; nothing was sent
  kError,      ///< broker, ledger or file trouble; the message says whether anything was sent
};

/// In the order of the enumeration.
inline constexpr std::array<std::string_view, 14> kCommandStatusNames = {
    "DRY_RUN",   "SENT",     "PUBLISHED", "ACCEPTED", "FINISHED", "FAILED",  "REJECTED",
    "RETRIABLE", "VANISHED", "OFFLINE",   "TIMEOUT",  "REFUSED",  "INVALID", "ERROR",
};
static_assert(kCommandStatusNames.size() == static_cast<std::size_t>(CommandStatus::kError) + 1);

/// `SENT`
[[nodiscard]] constexpr std::string_view GetName(CommandStatus status) {
  return kCommandStatusNames[static_cast<std::size_t>(status)];
}

/// What the ledger may say of a message; RECORDED while no outcome is known.
inline constexpr auto kRecordedStatuses = std::to_array<std::string_view>(
    {"RECORDED", GetName(CommandStatus::kSent), GetName(CommandStatus::kPublished),
     GetName(CommandStatus::kAccepted), GetName(CommandStatus::kFinished),
     GetName(CommandStatus::kFailed), GetName(CommandStatus::kRejected),
     GetName(CommandStatus::kRetriable), GetName(CommandStatus::kVanished),
     GetName(CommandStatus::kOffline), GetName(CommandStatus::kTimeout),
     GetName(CommandStatus::kError)});

/// The kind of trouble that a target's word means; nothing when it is none. (kInvalid, kRefused and
/// kError are ours: they carry the kind of their cause.)
[[nodiscard]] std::optional<ErrorKind> ToErrorKind(CommandStatus status);

}  // namespace fleetpub::message
