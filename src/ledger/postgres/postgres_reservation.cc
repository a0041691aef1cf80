#include "ledger/postgres/postgres_reservation.h"

#include <array>
#include <charconv>

#include "ledger/header_ids.h"
#include "ledger/stored_actions.h"

namespace fleetpub::ledger {
namespace {

constexpr std::string_view kWrite =
    "WITH taken AS (INSERT INTO fleetpub.header_ids AS h (topic, last, previous) "
    "SELECT * FROM unnest($1::text[], $2::bigint[], $3::bigint[]) "
    "ON CONFLICT (topic) DO UPDATE SET last = excluded.last, previous = excluded.previous "
    "WHERE h.last = excluded.previous RETURNING 1), "
    "recorded AS (INSERT INTO fleetpub.messages(recorded_at, \"user\", host, profile, broker, "
    "target, protocol, version, topic, header_id, actions, payload, status, detail) "
    "SELECT statement_timestamp(), $5, $6, $7, d.broker, d.target, d.protocol, d.version, d.topic, "
    "d.header_id, d.actions::jsonb, d.payload, 'RECORDED', '' "
    "FROM unnest($8::text[], $9::text[], $10::text[], $11::text[], $12::text[], $13::bigint[], "
    "$14::text[], $15::text[]) WITH ORDINALITY "
    "AS d(broker, target, protocol, version, topic, header_id, actions, payload, place) "
    "WHERE (SELECT count(*) FROM taken) = $4::bigint ORDER BY d.place RETURNING id) "
    "SELECT (SELECT count(*) FROM taken), pg_backend_pid(), "
    "(SELECT string_agg(id::text, ' ' ORDER BY id) FROM recorded)";

/// Three arrays: topics, their next ids, and what we take for their last.
void AddTopics(const Plan& plan, const LastIds& last_ids, Query& query) {
  ArrayText topics;
  ArrayText next;
  ArrayText last;
  for (const auto& [topic, id] : plan.next) {
    topics.Add(topic);
    next.Add(std::to_string(*id));
    if (const auto before = last_ids.find(topic)->second) {
      last.Add(std::to_string(*before));
    } else {
      last.AddNull();
    }
  }
  for (ArrayText* array : {&topics, &next, &last}) query.values.emplace_back(array->Take());
}

void AddRows(std::span<const Draft> drafts, const Plan& plan, Query& query) {
  std::array<ArrayText, 8> columns;
  auto& [broker, target, protocol, version, topic, header_id, actions, payload] = columns;
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    const Draft& draft = drafts[i];
    broker.Add(draft.broker);
    target.Add(draft.target);
    protocol.Add(draft.protocol);
    version.Add(draft.version);
    topic.Add(draft.topic);
    if (draft.counted) {
      header_id.Add(std::to_string(plan.ids[i]));
    } else {
      header_id.AddNull();
    }
    actions.Add(ActionsToJson(draft.actions));
    payload.Add(BuildPayload(draft, plan.ids[i]));
  }
  for (ArrayText& column : columns) query.values.emplace_back(column.Take());
}

/// `17 18 19`
std::vector<std::int64_t> NumbersIn(const std::string& text) {
  std::vector<std::int64_t> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::int64_t number = 0; at < end; ++at) {
    at = std::from_chars(at, end, number).ptr;
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

Query ReadingLastIds(std::span<const std::string> topics) {
  ArrayText array;
  for (const std::string& topic : topics) array.Add(topic);
  return {"SELECT topic, last FROM fleetpub.header_ids WHERE topic = ANY($1::text[])",
          {array.Take()}};
}

void TakeLastIds(const Rows& rows, LastIds& last_ids) {
  for (int row = 0; row < rows.count(); ++row) {
    last_ids[rows.Text(row, 0)] = static_cast<std::uint32_t>(rows.Integer(row, 1));
  }
}

Result<Plan> MakePlan(std::span<const Draft> drafts, const LastIds& last_ids, HeaderIdStart start) {
  Plan plan;
  plan.ids.reserve(drafts.size());
  for (const Draft& draft : drafts) {
    if (!draft.counted) {
      plan.ids.push_back(0);
      continue;
    }
    auto [topic, first] = plan.next.try_emplace(draft.topic);
    const auto last = first ? last_ids.find(draft.topic)->second : topic->second;
    const Result<std::uint32_t> id = ChooseId(draft, last, start);
    if (!id) return Fail(id.error());
    topic->second = *id;
    plan.ids.push_back(*id);
  }
  return plan;
}

Result<Written> WritePlan(Session& session, const Options& options, std::span<const Draft> drafts,
                          const Plan& plan, const LastIds& last_ids, Deadline deadline) {
  Query query{kWrite};
  AddTopics(plan, last_ids, query);
  query.values.emplace_back(std::to_string(plan.next.size()));
  for (const std::string* text : {&options.user, &options.host, &options.profile}) {
    query.values.emplace_back(*text);
  }
  AddRows(options.keep_history ? drafts : std::span<const Draft>(), plan, query);
  const Result<Rows> rows = session.Run(query, deadline);
  if (!rows) return Fail(rows.error());
  return Written{
      .taken = static_cast<std::size_t>(rows->Integer(0, 0)) == plan.next.size(),
      .backend = static_cast<int>(rows->Integer(0, 1)),
      .rows = NumbersIn(rows->Text(0, 2)),
  };
}

Status WriteOutcomes(Session& session, std::span<const StatusUpdate> outcomes, Deadline deadline) {
  std::map<std::int64_t, const StatusUpdate*> latest;
  for (const StatusUpdate& outcome : outcomes) {
    if (outcome.row != 0) latest[outcome.row] = &outcome;
  }
  if (latest.empty()) return {};
  ArrayText rows;
  ArrayText statuses;
  ArrayText details;
  for (const auto& [row, outcome] : latest) {
    rows.Add(std::to_string(row));
    statuses.Add(outcome->status);
    details.Add(outcome->detail);
  }
  const std::array<Query, 2> queries = {
      Query{"SELECT set_config('synchronous_commit', 'off', true)"},
      {"UPDATE fleetpub.messages AS m SET status = o.status, detail = o.detail, "
       "outcome_at = statement_timestamp() "
       "FROM unnest($1::bigint[], $2::text[], $3::text[]) AS o(id, status, detail) "
       "WHERE m.id = o.id",
       {rows.Take(), statuses.Take(), details.Take()}}};
  const auto done = session.Run(queries, deadline);
  if (!done) return Fail(done.error());
  return {};
}

}  // namespace fleetpub::ledger
