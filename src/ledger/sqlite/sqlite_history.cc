#include "ledger/sqlite/sqlite_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/json.h"
#include "ledger/stored_actions.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::microseconds;

constexpr char kSelect[] =
    "SELECT id, recorded_at, outcome_at, user, host, profile, broker, target, protocol, version, "
    "topic, header_id, actions, payload, status, detail FROM messages";

WallTime FromMicros(std::int64_t micros) { return WallTime(microseconds(micros)); }

Result<Record> ReadRecord(const Statement& row) {
  Record record;
  record.id = row.Integer(0);
  record.recorded_at = FromMicros(row.Integer(1));
  if (!row.IsNull(2)) record.outcome_at = FromMicros(row.Integer(2));
  int column = 3;
  for (std::string* text : {&record.user, &record.host, &record.profile, &record.broker,
                            &record.target, &record.protocol, &record.version, &record.topic}) {
    *text = row.Text(column++);
  }
  if (!row.IsNull(11)) record.header_id = static_cast<std::uint32_t>(row.Integer(11));
  Result<std::vector<ActionRef>> actions = ActionsFromJson(row.Text(12), record.id);
  if (!actions) return Fail(std::move(actions.error()));
  record.actions = std::move(*actions);
  record.payload = row.Text(13);
  record.status = row.Text(14);
  record.detail = row.Text(15);
  return record;
}

Result<std::vector<Record>> ReadAll(Statement& statement) {
  std::vector<Record> records;
  for (;;) {
    const Result<bool> row = statement.Step();
    if (!row) return Fail(row.error());
    if (!*row) return records;
    Result<Record> record = ReadRecord(statement);
    if (!record) return Fail(std::move(record.error()));
    records.push_back(std::move(*record));
  }
}

/// A quarter of a second's worth of deleting would already be felt by a command that waits.
constexpr std::int64_t kRowsPerTransaction = 1'000;

struct Span {
  std::int64_t first = 0;
  std::int64_t last = -1;
};

Result<Span> RowsBefore(Database& database, std::int64_t time) {
  Statement statement(database, "SELECT min(id), max(id) FROM messages WHERE recorded_at < ?1");
  const Result<bool> row = statement.Bind(1, time).Step();
  if (!row) return Fail(row.error());
  if (!*row || statement.IsNull(0)) return Span{};
  return Span{statement.Integer(0), statement.Integer(1)};
}

/// Not worth an error: the space is used by later rows anyway, and whoever is in the way may stay
/// there.
void GiveSpaceBack(Database& database) {
  Statement half_free(database,
                      "SELECT freelist_count * 2 > page_count AND page_count > 256 "
                      "FROM pragma_freelist_count, pragma_page_count");
  const Result<bool> row = half_free.Step();
  if (!row || !*row || half_free.Integer(0) == 0) return;
  half_free.Reset();
  static_cast<void>(database.Execute("VACUUM"));
}

}  // namespace

std::int64_t ToMicros(WallTime time) {
  return std::chrono::duration_cast<microseconds>(time.time_since_epoch()).count();
}

Result<std::vector<Record>> ReadHistory(Database& database, const HistoryFilter& filter) {
  constexpr auto kWhole = std::numeric_limits<std::int64_t>{};
  Statement statement(
      database,
      fmt::format(
          "{} WHERE (?1 = '' OR target = ?1) AND (?2 = '' OR status = ?2) "
          "AND (?3 = '' OR user = ?3) AND (?4 = '' OR EXISTS (SELECT 1 FROM json_each(actions) "
          "WHERE json_extract(value, '$.type') = ?4)) "
          "AND recorded_at >= ?5 AND recorded_at < ?6 AND id < ?7 AND (?9 = '[]' OR broker IN "
          "(SELECT value FROM json_each(?9))) "
          "ORDER BY id DESC LIMIT ?8",
          kSelect));
  statement.Bind(1, filter.target).Bind(2, filter.status).Bind(3, filter.user);
  statement.Bind(4, filter.action);
  statement.Bind(5, filter.since ? ToMicros(*filter.since) : kWhole.min());
  statement.Bind(6, filter.until ? ToMicros(*filter.until) : kWhole.max());
  statement.Bind(7, filter.below.value_or(kWhole.max()));
  statement.Bind(8, std::int64_t{filter.limit > 0 ? filter.limit : -1});
  const std::string brokers = base::JsonStrings(filter.brokers);  // until the statement has run
  statement.Bind(9, brokers);
  Result<std::vector<Record>> records = ReadAll(statement);
  if (records) std::reverse(records->begin(), records->end());
  return records;
}

Result<std::optional<Record>> FindRecord(Database& database, std::int64_t id) {
  Statement statement(database, fmt::format("{} WHERE id = ?1", kSelect));
  Result<std::vector<Record>> records = ReadAll(statement.Bind(1, id));
  if (!records) return Fail(std::move(records.error()));
  if (records->empty()) return std::optional<Record>();
  return std::optional<Record>(std::move(records->front()));
}

Result<std::int64_t> PruneHistory(Database& database, WallTime older_than,
                                  std::chrono::milliseconds time_each) {
  database.Allow(time_each);
  const std::int64_t time = ToMicros(older_than);
  const Result<Span> rows = RowsBefore(database, time);
  if (!rows) return Fail(rows.error());
  std::int64_t removed = 0;
  {
    Statement statement(database,
                        "DELETE FROM messages WHERE id BETWEEN ?1 AND ?2 AND recorded_at < ?3");
    for (std::int64_t id = rows->first; id <= rows->last; id += kRowsPerTransaction) {
      database.Allow(time_each);
      const std::int64_t end = std::min(rows->last, id + kRowsPerTransaction - 1);
      if (Status done = statement.Bind(1, id).Bind(2, end).Bind(3, time).Run(); !done) {
        return Fail(std::move(done.error()));
      }
      removed += database.Changes();
    }
  }
  database.Allow(time_each);
  GiveSpaceBack(database);
  database.Checkpoint(AfterCheckpoint::kNothingFollows);
  return removed;
}

}  // namespace fleetpub::ledger
