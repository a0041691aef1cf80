// The place of a ledger in PostgreSQL: `postgresql://[user@]host[:port]/database[?name=value…]`, as
// libpq takes it (PostgreSQL 15, §34.1.1.2).
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::ledger {

/// Whether a person means a database by this, rather than a file.
[[nodiscard]] bool IsUrl(std::string_view ledger);

/// Nothing when it may be handed to libpq. Errors: ErrorKind::kUsage for another scheme, a password
/// in it (never repeated), a control character.
[[nodiscard]] Status CheckPostgresUrl(std::string_view url);

/// For people: without parameters, which may name anything, and with a password masked.
[[nodiscard]] std::string FormatPlace(std::string_view url);

}  // namespace fleetpub::ledger
