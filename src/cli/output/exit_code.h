// Exit codes, in one place. They are a contract with scripts: docs/manual.md, "Exit codes".
#pragma once

#include <span>
#include <string_view>

#include "base/result.h"
#include "message/report.h"

namespace fleetpub::cli {

enum class ExitCode : int {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 2,
  kInvalid = 3,
  kBroker = 4,
  kRejected = 5,
  kUnconfirmed = 6,
  kPreflight = 7,
  kLedger = 8,
  kInterrupted = 130,
  kTerminated = 143,
};

struct ExitCodeMeaning {
  ExitCode code;
  std::string_view meaning;
};
/// Each, by number, in a few words.
[[nodiscard]] std::span<const ExitCodeMeaning> ExitCodeMeanings();

[[nodiscard]] ExitCode GetExitCode(ErrorKind kind);
[[nodiscard]] ExitCode GetExitCode(const message::Report& report);

/// Over several targets: the first of 130, 1, 8, 4, 5, 6, 7, 3, 2, 0 that occurred.
[[nodiscard]] ExitCode Worse(ExitCode a, ExitCode b);

}  // namespace fleetpub::cli
