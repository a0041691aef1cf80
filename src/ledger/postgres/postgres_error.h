// What PostgreSQL's words mean to a person who wants to command a robot.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::ledger {

/// SQLSTATEs that more than the explanation depends on (PostgreSQL, appendix A).
namespace sql_state {
constexpr std::string_view kUndefinedTable = "42P01";
constexpr std::string_view kUndefinedSchema = "3F000";
constexpr std::string_view kLockNotAvailable = "55P03";
}  // namespace sql_state

/// A statement failed. `state` is its SQLSTATE, empty when the connection failed under it; `text`
/// is PostgreSQL's or libpq's own. ErrorKind::kLedger: the place, the cause, the remedy.
[[nodiscard]] Error ExplainPostgres(std::string_view state, std::string_view text,
                                    const std::string& place);

/// No connection came about.
[[nodiscard]] Error CannotConnect(std::string_view text, const std::string& place);

/// After this SQLSTATE the server ends the connection.
[[nodiscard]] bool EndsTheConnection(std::string_view state);

}  // namespace fleetpub::ledger
