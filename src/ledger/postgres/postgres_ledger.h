// The ledger in a PostgreSQL database, for several hosts that command one fleet.
//
// Ids, rows and the topics' locks are in the database; nothing is on this host. The tables lie in
// the schema `fleetpub` and are made by the first who may.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/options.h"

namespace fleetpub::ledger {

struct PostgresOptions : Options {
  std::string url;  ///< `postgresql://…`, without a password
  /// Instead of what ~/.pgpass and the environment say.
  std::optional<std::string> password;
  std::chrono::milliseconds connect_timeout{10'000};
  /// How long the database may be gone while a command runs, and how long it may take to answer.
  std::chrono::milliseconds patience{5'000};
};

/// Connects. Errors: ErrorKind::kUsage for the URL; ErrorKind::kLedger, with the database, the
/// cause and the remedy, when it cannot be reached, refuses the login, has tables of a newer
/// version, or may not be written; when libpq is missing; and always in a static binary and in one
/// that was built without PostgreSQL (without_postgres.cc).
[[nodiscard]] Result<std::unique_ptr<Ledger>> OpenPostgres(PostgresOptions options, OpenMode mode);

}  // namespace fleetpub::ledger
