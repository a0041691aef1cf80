#include "ledger/sqlite/sqlite_reservation.h"

#include <chrono>
#include <string>
#include <utility>

#include "ledger/header_id_checkpoints.h"
#include "ledger/header_ids.h"
#include "ledger/sqlite/sqlite_history.h"
#include "ledger/stored_actions.h"

namespace fleetpub::ledger {
namespace {

/// The last ids of topics, prepared once for a whole batch. `marks` must outlive it.
class LastIds {
 public:
  LastIds(Database& database, const HeaderIdCheckpoints& marks)
      : checkpoints_(marks),
        read_(database, "SELECT last FROM header_ids WHERE topic = ?1"),
        write_(database, "INSERT OR REPLACE INTO header_ids(topic, last) VALUES(?1, ?2)") {}

  Result<std::optional<std::uint32_t>> Read(std::string_view topic) {
    const Result<bool> row = read_.Bind(1, topic).Step();
    if (!row) return Fail(row.error());
    std::optional<std::uint32_t> last;
    if (*row) last = static_cast<std::uint32_t>(read_.Integer(0));
    read_.Reset();
    return LaterId(last, checkpoints_.Read(topic));
  }

  Status Write(std::string_view topic, std::uint32_t last) {
    return write_.Bind(1, topic).Bind(2, std::int64_t{last}).Run();
  }

 private:
  const HeaderIdCheckpoints& checkpoints_;
  Statement read_;
  Statement write_;
};

/// Appends to the audit trail. `options` must outlive it.
class Recorder {
 public:
  Recorder(Database& database, const SqliteOptions& options)
      : database_(database),
        insert_(database,
                "INSERT INTO messages(recorded_at, user, host, profile, broker, target, protocol, "
                "version, topic, header_id, actions, payload, status, detail) "
                "VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, 'RECORDED', '')") {
    insert_.Bind(1, ToMicros(std::chrono::system_clock::now()));
    insert_.Bind(2, options.user).Bind(3, options.host).Bind(4, options.profile);
  }

  Result<std::int64_t> Add(const Draft& draft, std::uint32_t header_id) {
    const std::string actions = ActionsToJson(draft.actions);
    const std::string payload = BuildPayload(draft, header_id);
    insert_.Bind(5, draft.broker).Bind(6, draft.target).Bind(7, draft.protocol);
    insert_.Bind(8, draft.version).Bind(9, draft.topic).Bind(11, actions).Bind(12, payload);
    if (draft.counted) {
      insert_.Bind(10, std::int64_t{header_id});
    } else {
      insert_.BindNull(10);
    }
    if (Status done = insert_.Run(); !done) return Fail(std::move(done.error()));
    return database_.LastRowId();
  }

 private:
  Database& database_;
  Statement insert_;
};

Result<std::uint32_t> TakeId(const Draft& draft, LastIds& last_ids, HeaderIdStart start) {
  if (!draft.counted) return 0;
  const Result<std::optional<std::uint32_t>> last = last_ids.Read(draft.topic);
  if (!last) return Fail(last.error());
  Result<std::uint32_t> id = ChooseId(draft, *last, start);
  if (!id) return id;
  if (Status written = last_ids.Write(draft.topic, *id); !written) return Fail(written.error());
  return id;
}

Result<std::vector<Reservation>> ReserveEach(Database& database, const HeaderIdCheckpoints& marks,
                                             const SqliteOptions& options,
                                             std::span<const Draft> drafts) {
  LastIds last_ids(database, marks);
  std::optional<Recorder> recorder;
  if (options.keep_history) recorder.emplace(database, options);
  std::vector<Reservation> reservations;
  reservations.reserve(drafts.size());
  for (const Draft& draft : drafts) {
    const Result<std::uint32_t> id = TakeId(draft, last_ids, options.start);
    if (!id) return Fail(id.error());
    const Result<std::int64_t> row = recorder ? recorder->Add(draft, *id) : 0;
    if (!row) return Fail(row.error());
    reservations.push_back({*row, *id});
  }
  return reservations;
}

}  // namespace

Result<std::optional<std::uint32_t>> ReadLastId(Database& database, std::string_view topic) {
  return LastIds(database, HeaderIdCheckpoints(database.path())).Read(topic);
}

Result<std::vector<Reservation>> ReserveAll(Database& database, const SqliteOptions& options,
                                            std::span<const Draft> drafts) {
  if (Status set = database.SetDurability(Durability::kFull); !set) return Fail(set.error());
  Transaction transaction(database);
  if (Status begun = transaction.Begin(); !begun) return Fail(begun.error());
  const HeaderIdCheckpoints marks(database.path());
  Result<std::vector<Reservation>> reservations = ReserveEach(database, marks, options, drafts);
  if (!reservations) return reservations;
  if (Status done = transaction.Commit(); !done) return Fail(done.error());
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    if (drafts[i].counted) marks.Write(drafts[i].topic, (*reservations)[i].header_id);
  }
  return reservations;
}

Status WriteOutcomes(Database& database, std::span<const StatusUpdate> outcomes) {
  if (Status set = database.SetDurability(Durability::kNormal); !set) return set;
  Transaction transaction(database);
  if (Status begun = transaction.Begin(); !begun) return begun;
  Statement update(database,
                   "UPDATE messages SET status = ?2, detail = ?3, outcome_at = ?4 WHERE id = ?1");
  update.Bind(4, ToMicros(std::chrono::system_clock::now()));
  for (const StatusUpdate& outcome : outcomes) {
    if (outcome.row == 0) continue;
    Status done = update.Bind(1, outcome.row).Bind(2, outcome.status).Bind(3, outcome.detail).Run();
    if (!done) return done;
  }
  return transaction.Commit();
}

}  // namespace fleetpub::ledger
