// What became of a command: the one shape that text, JSON, exit code and audit trail are made of.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"

namespace fleetpub::dispatch {

/// The closed list of outcomes. Their names stand in JSON, in the ledger and in the manual.
enum class Verdict {
  kDryRun,     ///< built and validated; nothing was sent
  kSent,       ///< handed to the operating system at QoS 0: a hope
  kPublished,  ///< acknowledged by the broker
  kInvalid,    ///< breaks the specification; nothing was sent
  kError,      ///< broker, ledger or file trouble; the message says whether anything was sent
};

/// `SENT`
[[nodiscard]] std::string_view NameOf(Verdict verdict);

struct Report {
  std::string target;
  std::string protocol;
  std::string version;
  bool version_assumed = false;
  std::string topic;
  std::vector<ledger::ActionRef> actions;
  std::optional<std::uint32_t> header_id;  ///< none when nothing was stamped
  Verdict verdict = Verdict::kError;
  std::string message;  ///< why, when it is not a success; one line
  /// Which kind of trouble, when there was some.
  std::optional<ErrorKind> error;
  std::string payload;  ///< as sent, or as it would be
  std::chrono::nanoseconds elapsed{0};
};

}  // namespace fleetpub::dispatch
