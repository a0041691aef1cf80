// What a function returns when the world can refuse: a value, or an Error that a person can read.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace fleetpub::base {

/// Which kind of trouble. Decides the exit code (cli/output/exit_code.h) and nothing else.
enum class ErrorKind {
  kUnexpected,   ///< nobody foresaw it
  kUsage,        ///< the arguments or the configuration are wrong; nothing was sent
  kInvalid,      ///< a message or parameter breaks the specification; nothing was sent
  kBroker,       ///< unreachable, refused, TLS, login, access list, connection lost
  kRejected,     ///< the robot said no
  kUnconfirmed,  ///< the robot did not say
  kPreflight,    ///< refused by us before sending: unknown, offline, not supported
  kLedger,       ///< ledger or file trouble; nothing was sent
};

struct Error {
  ErrorKind kind = ErrorKind::kUnexpected;
  /// One line for a person: what was wrong, where, and what to do. No full stop at its end.
  std::string message;
  /// What a library or the system said, for `-v`. Often empty, never a secret.
  std::string detail = {};
};

template <typename T>
using Result = tl::expected<T, Error>;

using Status = Result<void>;

/// `return Fail(ErrorKind::kUsage, "…");`
[[nodiscard]] inline tl::unexpected<Error> Fail(ErrorKind kind, std::string message,
                                                std::string detail = {}) {
  return tl::unexpected<Error>(Error{kind, std::move(message), std::move(detail)});
}

/// Hands an error on: `if (!r) return Fail(std::move(r.error()));`
[[nodiscard]] inline tl::unexpected<Error> Fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace fleetpub::base

namespace fleetpub {
using base::Error;
using base::ErrorKind;
using base::Fail;
using base::Result;
using base::Status;
}  // namespace fleetpub
