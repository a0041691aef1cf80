// In place of this folder's other files, when FLEETPUB_POSTGRES is off.
#include "ledger/postgres/postgres_ledger.h"
#include "ledger/postgres/postgres_url.h"

namespace fleetpub::ledger {

// NOLINTNEXTLINE(performance-unnecessary-value-param): the ledger keeps them
Result<std::unique_ptr<Ledger>> OpenPostgres(PostgresOptions options, OpenMode /*mode*/) {
  if (Status right = CheckPostgresUrl(options.url); !right) return Fail(std::move(right.error()));
  return Fail(
      ErrorKind::kLedger,
      "this fleetpub was built without PostgreSQL (FLEETPUB_POSTGRES=OFF): install one that "
      "was built with it, or name a file with --ledger");
}

}  // namespace fleetpub::ledger
