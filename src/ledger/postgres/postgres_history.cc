#include "ledger/postgres/postgres_history.h"

#include <algorithm>
#include <string>

#include "base/json.h"
#include "ledger/stored_actions.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::microseconds;

/// Times travel as microseconds since 1970.
constexpr std::string_view kSelect =
    "SELECT id, (extract(epoch FROM recorded_at) * 1000000)::bigint, "
    "(extract(epoch FROM outcome_at) * 1000000)::bigint, \"user\", host, profile, broker, target, "
    "protocol, version, topic, header_id, actions, payload, status, detail FROM fleetpub.messages ";

constexpr int kRowsPerTransaction = 10'000;

std::string FormatMicros(WallTime time) {
  return std::to_string(std::chrono::duration_cast<microseconds>(time.time_since_epoch()).count());
}

std::optional<std::string> FormatMicros(const std::optional<WallTime>& time) {
  if (!time) return std::nullopt;
  return FormatMicros(*time);
}

/// Nothing: no filter.
std::optional<std::string> Wanted(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return text;
}

Result<Record> ReadRecord(const Rows& rows, int row) {
  const auto time = [&](int column) { return WallTime(microseconds(rows.Integer(row, column))); };
  Record record;
  record.id = rows.Integer(row, 0);
  record.recorded_at = time(1);
  if (!rows.IsNull(row, 2)) record.outcome_at = time(2);
  int column = 3;
  for (std::string* text : {&record.user, &record.host, &record.profile, &record.broker,
                            &record.target, &record.protocol, &record.version, &record.topic}) {
    *text = rows.Text(row, column++);
  }
  if (!rows.IsNull(row, 11)) record.header_id = static_cast<std::uint32_t>(rows.Integer(row, 11));
  auto actions = ActionsFromJson(rows.Text(row, 12), record.id);
  if (!actions) return Fail(std::move(actions.error()));
  record.actions = std::move(*actions);
  record.payload = rows.Text(row, 13);
  record.status = rows.Text(row, 14);
  record.detail = rows.Text(row, 15);
  return record;
}

Result<std::vector<Record>> ReadAll(const Result<Rows>& rows) {
  if (!rows) return Fail(rows.error());
  std::vector<Record> records;
  records.reserve(static_cast<std::size_t>(rows->count()));
  for (int row = 0; row < rows->count(); ++row) {
    Result<Record> record = ReadRecord(*rows, row);
    if (!record) return Fail(std::move(record.error()));
    records.push_back(std::move(*record));
  }
  return records;
}

}  // namespace

Result<std::vector<Record>> ReadHistory(Session& session, const HistoryFilter& filter,
                                        Deadline deadline) {
  const std::string sql =
      std::string(kSelect) +
      "WHERE ($1::text IS NULL OR target = $1) AND ($2::text IS NULL OR status = $2) "
      "AND ($3::text IS NULL OR \"user\" = $3) AND ($4::text IS NULL OR "
      "actions @> jsonb_build_array(jsonb_build_object('type', $4::text))) "
      "AND ($5::bigint IS NULL OR recorded_at >= timestamptz 'epoch' + $5 * interval '1 us') "
      "AND ($6::bigint IS NULL OR recorded_at < timestamptz 'epoch' + $6 * interval '1 us') "
      "AND ($7::bigint IS NULL OR id < $7) AND ($9::jsonb IS NULL OR $9::jsonb ? broker) "
      "ORDER BY id DESC LIMIT $8";
  const Query query = {
      sql,
      {Wanted(filter.target), Wanted(filter.status), Wanted(filter.user), Wanted(filter.action),
       FormatMicros(filter.since), FormatMicros(filter.until),
       filter.below ? std::optional(std::to_string(*filter.below)) : std::nullopt,
       filter.limit > 0 ? std::optional(std::to_string(filter.limit)) : std::nullopt,
       filter.brokers.empty() ? std::nullopt : std::optional(base::JsonStrings(filter.brokers))}};
  auto records = ReadAll(session.Run(query, deadline));
  if (records) std::reverse(records->begin(), records->end());
  return records;
}

Result<std::optional<Record>> FindRecord(Session& session, std::int64_t id, Deadline deadline) {
  const std::string sql = std::string(kSelect) + "WHERE id = $1";
  auto records = ReadAll(session.Run(Query{sql, {std::to_string(id)}}, deadline));
  if (!records) return Fail(std::move(records.error()));
  if (records->empty()) return std::optional<Record>();
  return std::optional<Record>(std::move(records->front()));
}

Result<std::int64_t> PruneHistory(Session& session, WallTime older_than,
                                  std::chrono::milliseconds patience) {
  const Query query = {
      "DELETE FROM fleetpub.messages WHERE id IN (SELECT id FROM fleetpub.messages "
      "WHERE recorded_at < timestamptz 'epoch' + $1::bigint * interval '1 us' "
      "ORDER BY id LIMIT $2)",
      {FormatMicros(older_than), std::to_string(kRowsPerTransaction)}};
  for (std::int64_t removed = 0;;) {
    const auto rows = session.Run(query, std::chrono::steady_clock::now() + patience);
    if (!rows) return Fail(rows.error());
    removed += rows->Changes();
    if (rows->Changes() < kRowsPerTransaction) return removed;
  }
}

}  // namespace fleetpub::ledger
