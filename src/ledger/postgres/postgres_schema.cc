#include "ledger/postgres/postgres_schema.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "ledger/postgres/postgres_error.h"

namespace fleetpub::ledger {
namespace {

// Topics compare byte by byte (COLLATE "C"): an index in a language's order breaks when an update
// of the C library changes that order, and a broken index finds no last id. `previous` is what a
// writer takes the last id for: see postgres_reservation.h. Room in the pages of header_ids lets
// an update stay in its page. The index on the time is a few bytes per hundred pages: the rows lie
// in the order of their time.
constexpr std::array kFirstVersion = {
    "CREATE TABLE fleetpub.ledger_version(version integer NOT NULL)",
    "INSERT INTO fleetpub.ledger_version VALUES (0)",
    "CREATE TABLE fleetpub.header_ids("
    "topic text COLLATE \"C\" PRIMARY KEY, "
    "last bigint NOT NULL CHECK (last BETWEEN 0 AND 4294967295), previous bigint"
    ") WITH (fillfactor = 50)",
    "CREATE TABLE fleetpub.messages("
    "id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY, recorded_at timestamptz NOT NULL, "
    "outcome_at timestamptz, \"user\" text NOT NULL, host text NOT NULL, profile text NOT NULL, "
    "broker text NOT NULL, target text NOT NULL, protocol text NOT NULL, version text NOT NULL, "
    "topic text NOT NULL, header_id bigint, actions jsonb NOT NULL, payload text NOT NULL, "
    "status text NOT NULL, detail text NOT NULL)",
    "CREATE INDEX messages_recorded_at ON fleetpub.messages USING brin (recorded_at)",
};

/// The nth brings version n to n + 1.
constexpr std::array<std::span<const char* const>, 1> kMigrations = {kFirstVersion};
constexpr int kVersion = static_cast<int>(kMigrations.size());

// lock_timeout is for rows and tables: whoever alters them should not make a command wait long. The
// server learns within 25 s that a host is gone, and gives its locks away; a host that is cut off
// from the server has given up sending by then (SendOptions::acknowledge_timeout).
constexpr Query kSettings = {
    "SELECT set_config(name, value, false) FROM (VALUES "
    "('search_path', 'pg_catalog'), ('default_transaction_isolation', 'read committed'), "
    "('lock_timeout', '5s'), ('statement_timeout', '0'), ('idle_session_timeout', '0'), "
    "('tcp_keepalives_idle', '10'), ('tcp_keepalives_interval', '5'), "
    "('tcp_keepalives_count', '3'), ('synchronous_commit', "
    "CASE current_setting('synchronous_commit') WHEN 'off' THEN 'on' "
    "ELSE current_setting('synchronous_commit') END)) AS setting(name, value) "
    "WHERE current_setting(name, true) IS NOT NULL"};

constexpr std::string_view kSelectVersion = "SELECT version FROM fleetpub.ledger_version";

Error NewerThanWe(int version, const std::string& place) {
  return {ErrorKind::kLedger,
          fmt::format("the ledger {} was written by a newer fleetpub: update this one", place),
          fmt::format("version {} of the tables, {} known", version, kVersion)};
}

/// Within a transaction that holds the lock.
Result<int> CurrentVersion(Session& session, Deadline deadline) {
  const auto there = session.Run({"SELECT to_regclass('fleetpub.ledger_version') IS NOT NULL, "
                                  "to_regnamespace('fleetpub') IS NOT NULL"},
                                 deadline);
  if (!there) return Fail(there.error());
  if (there->Text(0, 0) == "t") {
    const auto version = session.Run({kSelectVersion}, deadline);
    if (!version) return Fail(version.error());
    return version->count() == 0 ? 0 : static_cast<int>(version->Integer(0, 0));
  }
  if (there->Text(0, 1) == "t") return 0;  // an administrator made it for us
  const auto made = session.Run({"CREATE SCHEMA fleetpub"}, deadline);
  if (!made) return Fail(made.error());
  return 0;
}

Status RunMigrations(Session& session, Deadline deadline) {
  const Result<int> version = CurrentVersion(session, deadline);
  if (!version) return Fail(version.error());
  if (*version > kVersion) return Fail(NewerThanWe(*version, session.place()));
  std::vector<Query> queries;
  for (std::size_t step = static_cast<std::size_t>(*version); step < kMigrations.size(); ++step) {
    for (const char* sql : kMigrations[step]) queries.push_back({sql});
  }
  queries.push_back(
      {"UPDATE fleetpub.ledger_version SET version = $1", {std::to_string(kVersion)}});
  queries.push_back({"COMMIT"});
  const auto done = session.Run(queries, deadline);
  if (!done) return Fail(done.error());
  return {};
}

}  // namespace

std::int64_t LockKey(std::string_view topic) {
  std::uint64_t hash = 14'695'981'039'346'656'037U;  // FNV-1a
  const auto add = [&](std::string_view text) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1'099'511'628'211U;
  };
  add("fleetpub ");  // others may use advisory locks in this database
  add(topic);
  return static_cast<std::int64_t>(hash);
}

Result<int> PrepareSession(Session& session, Deadline deadline) {
  const std::array<Query, 2> both = {kSettings, {kSelectVersion}};
  const auto rows = session.Run(both, deadline);
  if (rows) {
    const Rows& version = rows->back();
    const int found = version.count() == 0 ? 0 : static_cast<int>(version.Integer(0, 0));
    if (found > kVersion) return Fail(NewerThanWe(found, session.place()));
    return found;
  }
  const bool no_tables = session.state() == sql_state::kUndefinedTable ||
                         session.state() == sql_state::kUndefinedSchema;
  if (!no_tables) return Fail(rows.error());
  const auto set = session.Run(kSettings, deadline);  // the failure took them back
  if (!set) return Fail(set.error());
  return 0;
}

Status MigrateTables(Session& session, Deadline deadline) {
  const std::array<Query, 2> begin = {
      Query{"BEGIN"}, {"SELECT pg_advisory_xact_lock($1)", {std::to_string(LockKey(""))}}};
  const auto begun = session.Run(begin, deadline);
  Status migrated = begun ? RunMigrations(session, deadline) : Status(Fail(begun.error()));
  if (!migrated) session.Post({"ROLLBACK"});
  return migrated;
}

Result<LedgerInfo> DescribeTables(Session& session, Deadline deadline) {
  const auto rows = session.Run(
      {"SELECT (SELECT version FROM fleetpub.ledger_version), "
       "(SELECT count(*) FROM fleetpub.messages), (SELECT count(*) FROM fleetpub.header_ids), "
       "pg_total_relation_size('fleetpub.messages') + "
       "pg_total_relation_size('fleetpub.header_ids')"},
      deadline);
  if (!rows) return Fail(rows.error());
  return LedgerInfo{.kind = "PostgreSQL",
                    .place = session.place(),
                    .version = static_cast<int>(rows->Integer(0, 0)),
                    .rows = rows->Integer(0, 1),
                    .topics = rows->Integer(0, 2),
                    .bytes = rows->Integer(0, 3)};
}

}  // namespace fleetpub::ledger
