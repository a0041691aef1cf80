#include "ledger/postgres/postgres_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"

namespace fleetpub::ledger {
namespace {

struct Remedy {
  std::string_view state;  ///< or how it begins
  std::string_view what;   ///< `{}` is the place
};

constexpr auto kRemedies = std::to_array<Remedy>({
    {"42501",
     "this user may not do that in the ledger {}: let its owner run `fleetpub ledger migrate` and "
     "grant what the manual names under \"PostgreSQL\""},
    {"25006", "the ledger {} is read-only, a standby perhaps: name the primary server"},
    {"53100", "there is no room left for the ledger {}: free some on the database server"},
    {"53200",
     "the ledger {} has no room for more locks: raise max_locks_per_transaction on the database "
     "server"},
    {"55P03", "the ledger {} is locked by somebody else: try again"},
    {"57P0", "the server of the ledger {} shut down or ended the connection: try again"},
    {"42P01", "the ledger {} has no tables: run fleetpub ledger migrate"},
    {"22021", "the ledger {} cannot hold a text: make its database with ENCODING 'UTF8'"},
    {"22P05", "the ledger {} cannot hold a text: make its database with ENCODING 'UTF8'"},
});

struct Cause {
  std::string_view part;   ///< of what libpq says
  std::string_view words;  ///< what a person reads instead
};

constexpr auto kCauses = std::to_array<Cause>({
    {"password",
     "the password is missing or not accepted: put it into ~/.pgpass, the file that PGPASSFILE "
     "names, or PGPASSWORD"},
    {"pg_hba.conf", "the server does not admit this user from here: see its pg_hba.conf"},
    {"could not translate host name", "its host name is not known"},
    {"Connection refused", "connection refused: is a server running there?"},
    {"No such file", "no server listens there: is one running on this machine?"},
    {"timeout expired",
     "no answer in time: is the address right, and does a firewall let it through?"},
    {"timed out", "no answer in time: is the address right, and does a firewall let it through?"},
    {"certificate", "TLS: its certificate is not accepted: see sslmode and sslrootcert"},
    {"SSL", "TLS: the two do not agree on it: see sslmode"},
    {"database \"", "there is no such database, or this user may not use it"},
    {"role \"", "there is no such user"},
    {"starting up", "the server is just starting: try again"},
    {"shutting down", "the server is just ending: try again"},
    {"connection slots", "the server has no connection left: try again later"},
    {"too many clients", "the server has no connection left: try again later"},
    {"read-only", "only a standby answers, which is read-only: name the primary server"},
    {"invalid", "its URL has a parameter that libpq does not know"},
});

/// libpq's messages end with a line break, and may have several lines, one per address tried.
std::string OneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == '\n' || c == '\t' || c == ' ';
    if (!blank || (!line.empty() && line.back() != ' ')) line += blank ? ' ' : c;
  }
  while (line.ends_with(' ')) line.pop_back();
  return base::Printable(line);
}

}  // namespace

bool EndsTheConnection(std::string_view state) {
  return state.starts_with("57P0") || state.starts_with("08");
}

Error ExplainPostgres(std::string_view state, std::string_view text, const std::string& place) {
  const std::string said = OneLine(text);
  const auto remedy = std::find_if(kRemedies.begin(), kRemedies.end(), [&](const Remedy& known) {
    return state.starts_with(known.state);
  });
  if (remedy != kRemedies.end()) {
    return {ErrorKind::kLedger, fmt::format(fmt::runtime(remedy->what), place), said};
  }
  if (state.empty()) {
    return {ErrorKind::kLedger, fmt::format("the connection to the ledger {} was lost", place),
            said};
  }
  return {ErrorKind::kLedger,
          fmt::format("the ledger {} refuses (SQLSTATE {}): -v tells its reason", place, state),
          said};
}

Error CannotConnect(std::string_view text, const std::string& place) {
  const std::string said = OneLine(text);
  const auto cause = std::find_if(kCauses.begin(), kCauses.end(), [&](const Cause& known) {
    return said.find(known.part) != std::string::npos;
  });
  return {ErrorKind::kLedger,
          fmt::format("cannot reach the ledger {}: {}", place,
                      cause == kCauses.end() ? "-v tells the reason" : cause->words),
          said};
}

}  // namespace fleetpub::ledger
