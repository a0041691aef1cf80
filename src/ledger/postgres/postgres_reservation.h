// Giving header ids and writing rows in PostgreSQL.
//
// The ids are chosen here, by the rules that all ledgers share, from the topics' last ids; the
// database takes them only if those are still the last ones: each row of header_ids is written with
// the id that its writer took for the last, and not at all when another one stands there. So no id
// is given twice even without the topics' locks, and those may read the last ids along with the
// locking, which leaves one round trip for reserving and recording.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "ledger/ledger.h"
#include "ledger/options.h"
#include "ledger/postgres/postgres_session.h"

namespace fleetpub::ledger {

/// Topic → its last id; nothing: it has had none.
using LastIds = std::map<std::string, std::optional<std::uint32_t>, std::less<>>;

/// The topics' last ids. `topics` as in Ledger::Lock.
[[nodiscard]] Query ReadingLastIds(std::span<const std::string> topics);
void TakeLastIds(const Rows& rows, LastIds& last_ids);

/// What a reservation writes.
struct Plan {
  std::vector<std::uint32_t> ids;  ///< of each draft
  LastIds next;                    ///< of each counted topic
};

/// Errors: ErrorKind::kUsage, as of Ledger::Reserve. `last_ids` must know every topic.
[[nodiscard]] Result<Plan> MakePlan(std::span<const Draft> drafts, const LastIds& last_ids,
                                    HeaderIdStart start);

struct Written {
  bool taken = false;  ///< false: a topic's last id is another one by now; no row was written
  int backend = 0;     ///< the server process that did it
  std::vector<std::int64_t> rows;  ///< of each draft; empty without history
};

/// One statement.
[[nodiscard]] Result<Written> WritePlan(Session& session, const Options& options,
                                        std::span<const Draft> drafts, const Plan& plan,
                                        const LastIds& last_ids, Deadline deadline);

/// Outcomes of row 0 are passed over.
[[nodiscard]] Status WriteOutcomes(Session& session, std::span<const StatusUpdate> outcomes,
                                   Deadline deadline);

}  // namespace fleetpub::ledger
