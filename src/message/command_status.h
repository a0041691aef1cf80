// The closed list of what can become of a command, and what each is called and counts as.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "base/result.h"

namespace fleetpub::message {

enum class CommandStatus {
  kDryRun,       ///< built and validated; nothing was sent
  kSent,         ///< handed to the operating system at QoS 0: a hope
  kPublished,    ///< acknowledged by the broker
  kAccepted,     ///< the target lists it and has not refused it
  kFinished,     ///< the target says that it is done
  kNoOrder,      ///< the target says that it has no order, or not this one, to cancel
  kFailed,       ///< the target says that it failed
  kRejected,     ///< the target refused it
  kRetriable,    ///< neither done nor failed: it waits for retry, skipRetry or a person
  kVanished,     ///< the target had listed it and no longer does, without an end
  kOffline,      ///< the target lost its connection while we waited
  kTimeout,      ///< the target did not say in time
  kInterrupted,  ///< whoever waited has stopped waiting (Ctrl-C)
  kRefused,      ///< by us, before sending: unknown, offline, not supported
  kInvalid,      ///< breaks the specification; nothing was sent
  kError,        ///< broker, ledger or file trouble; the message says whether anything was sent
};

/// Under which word a summary counts it.
enum class StatusGroup {
  kFinished,
  kSent,
  kNoOrder,
  kFailed,
  kUnconfirmed,
  kOffline,
  kRefused,
  kErrors,
};

/// What a status is called and means, wherever the command came from: the one table that words,
/// summaries and exit codes are made of.
struct StatusFacts {
  std::string_view name;  ///< in JSON, in the ledger and in the manual
  StatusGroup group;
  /// The kind of trouble that a target's word means; nothing when it is none. (kInvalid, kRefused
  /// and kError are ours: they carry the kind of their cause. So does a kOffline that was known
  /// before sending.)
  std::optional<ErrorKind> trouble = std::nullopt;
};

/// In the order of the enumeration.
inline constexpr std::array<StatusFacts, 16> kCommandStatuses = {{
    {"DRY_RUN", StatusGroup::kSent},
    {"SENT", StatusGroup::kSent},
    {"PUBLISHED", StatusGroup::kSent},
    {"ACCEPTED", StatusGroup::kFinished},
    {"FINISHED", StatusGroup::kFinished},
    {"NO_ORDER", StatusGroup::kNoOrder, ErrorKind::kRejected},
    {"FAILED", StatusGroup::kFailed, ErrorKind::kRejected},
    {"REJECTED", StatusGroup::kFailed, ErrorKind::kRejected},
    {"RETRIABLE", StatusGroup::kUnconfirmed, ErrorKind::kUnconfirmed},
    {"VANISHED", StatusGroup::kUnconfirmed, ErrorKind::kUnconfirmed},
    {"OFFLINE", StatusGroup::kOffline, ErrorKind::kUnconfirmed},
    {"TIMEOUT", StatusGroup::kUnconfirmed, ErrorKind::kUnconfirmed},
    {"INTERRUPTED", StatusGroup::kUnconfirmed, ErrorKind::kUnconfirmed},
    {"REFUSED", StatusGroup::kRefused},
    {"INVALID", StatusGroup::kRefused},
    {"ERROR", StatusGroup::kErrors},
}};
static_assert(kCommandStatuses.size() == static_cast<std::size_t>(CommandStatus::kError) + 1);

[[nodiscard]] constexpr const StatusFacts& GetFacts(CommandStatus status) {
  return kCommandStatuses[static_cast<std::size_t>(status)];
}

/// `SENT`
[[nodiscard]] constexpr std::string_view GetName(CommandStatus status) {
  return GetFacts(status).name;
}

[[nodiscard]] constexpr std::optional<ErrorKind> ToErrorKind(CommandStatus status) {
  return GetFacts(status).trouble;
}

/// What the ledger may say of a message; RECORDED while no outcome is known.
inline constexpr auto kRecordedStatuses = std::to_array<std::string_view>(
    {"RECORDED", GetName(CommandStatus::kSent), GetName(CommandStatus::kPublished),
     GetName(CommandStatus::kAccepted), GetName(CommandStatus::kFinished),
     GetName(CommandStatus::kNoOrder), GetName(CommandStatus::kFailed),
     GetName(CommandStatus::kRejected), GetName(CommandStatus::kRetriable),
     GetName(CommandStatus::kVanished), GetName(CommandStatus::kOffline),
     GetName(CommandStatus::kTimeout), GetName(CommandStatus::kInterrupted),
     GetName(CommandStatus::kError)});

}  // namespace fleetpub::message
