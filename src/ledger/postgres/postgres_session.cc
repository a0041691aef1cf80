#include "ledger/postgres/postgres_session.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "base/time.h"
#include "ledger/postgres/postgres_error.h"
#include "ledger/postgres/postgres_url.h"

namespace fleetpub::ledger {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Everything of libpq that is used. Pipelines came with libpq 14.
struct Libpq {
  decltype(&::PQconnectdbParams) connectdb_params;
  decltype(&::PQfinish) finish;
  decltype(&::PQstatus) status;
  decltype(&::PQerrorMessage) error_message;
  decltype(&::PQsocket) socket;
  decltype(&::PQsetNoticeProcessor) set_notice_processor;
  decltype(&::PQsetnonblocking) set_nonblocking;
  decltype(&::PQenterPipelineMode) enter_pipeline_mode;
  decltype(&::PQsendQueryParams) send_query_params;
  decltype(&::PQpipelineSync) pipeline_sync;
  decltype(&::PQflush) flush;
  decltype(&::PQconsumeInput) consume_input;
  decltype(&::PQisBusy) is_busy;
  decltype(&::PQgetResult) get_result;
  decltype(&::PQresultStatus) result_status;
  decltype(&::PQresultErrorField) result_error_field;
  decltype(&::PQresultErrorMessage) result_error_message;
  decltype(&::PQntuples) ntuples;
  decltype(&::PQgetisnull) getisnull;
  decltype(&::PQgetvalue) getvalue;
  decltype(&::PQgetlength) getlength;
  decltype(&::PQcmdTuples) cmd_tuples;
  decltype(&::PQclear) clear;
};

#ifndef FLEETPUB_STATIC

template <typename Function>
bool Find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

bool FindAll(void* library, Libpq& pq) {
  return Find(library, "PQconnectdbParams", pq.connectdb_params) &&
         Find(library, "PQfinish", pq.finish) && Find(library, "PQstatus", pq.status) &&
         Find(library, "PQerrorMessage", pq.error_message) &&
         Find(library, "PQsocket", pq.socket) &&
         Find(library, "PQsetNoticeProcessor", pq.set_notice_processor) &&
         Find(library, "PQsetnonblocking", pq.set_nonblocking) &&
         Find(library, "PQenterPipelineMode", pq.enter_pipeline_mode) &&
         Find(library, "PQsendQueryParams", pq.send_query_params) &&
         Find(library, "PQpipelineSync", pq.pipeline_sync) && Find(library, "PQflush", pq.flush) &&
         Find(library, "PQconsumeInput", pq.consume_input) &&
         Find(library, "PQisBusy", pq.is_busy) && Find(library, "PQgetResult", pq.get_result) &&
         Find(library, "PQresultStatus", pq.result_status) &&
         Find(library, "PQresultErrorField", pq.result_error_field) &&
         Find(library, "PQresultErrorMessage", pq.result_error_message) &&
         Find(library, "PQntuples", pq.ntuples) && Find(library, "PQgetisnull", pq.getisnull) &&
         Find(library, "PQgetvalue", pq.getvalue) && Find(library, "PQgetlength", pq.getlength) &&
         Find(library, "PQcmdTuples", pq.cmd_tuples) && Find(library, "PQclear", pq.clear);
}

Result<Libpq> Load() {
  void* library = dlopen("libpq.so.5", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return Fail(ErrorKind::kLedger,
                "a ledger in PostgreSQL needs libpq: install it (Debian: libpq5)", dlerror());
  }
  Libpq pq{};
  if (FindAll(library, pq)) return pq;
  return Fail(ErrorKind::kLedger, "a ledger in PostgreSQL needs libpq 14 or newer: update it");
}

#else

// A static glibc binary can load a library only beside the very glibc that it was linked with.
Result<Libpq> Load() {
  return Fail(ErrorKind::kLedger,
              "this fleetpub is linked statically and cannot load libpq: use the packaged one for "
              "a ledger in PostgreSQL, or name a file");
}

#endif

const Result<Libpq>& Library() {
  static const Result<Libpq> library = Load();
  return library;
}

/// Once a Session is there, the library is.
const Libpq& Pq() { return *Library(); }

std::string WholeSeconds(milliseconds time) {
  return std::to_string(std::max<std::int64_t>(
      2, std::chrono::ceil<std::chrono::seconds>(time).count()));  // libpq makes 2 of 1
}

pg_conn* Open(const SessionOptions& options) {
  const std::string timeout = WholeSeconds(options.connect_timeout);
  // Of two that set the same, the later holds: what stands before the URL are defaults.
  std::vector<const char*> names = {"connect_timeout", "fallback_application_name",
                                    "target_session_attrs", "dbname", "client_encoding"};
  std::vector<const char*> values = {timeout.c_str(), options.name.c_str(),
                                     options.writable ? "read-write" : "any", options.url.c_str(),
                                     "UTF8"};
  if (options.password) {
    names.push_back("password");
    values.push_back(options.password->c_str());
  }
  names.push_back(nullptr);
  values.push_back(nullptr);
  return Pq().connectdb_params(names.data(), values.data(), 1);
}

int LeftUntil(Session::Deadline deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
  return static_cast<int>(std::clamp<milliseconds::rep>(left.count(), 0, 3'600'000));
}

}  // namespace

void ArrayText::Add(std::string_view element) {
  if (text_.size() > 1) text_ += ',';
  text_ += '"';
  for (const char c : element) {
    if (c == '"' || c == '\\') text_ += '\\';
    text_ += c;
  }
  text_ += '"';
}

void ArrayText::AddNull() { text_ += text_.size() > 1 ? ",NULL" : "NULL"; }

std::string ArrayText::Take() { return std::move(text_) + "}"; }

void Rows::Clear(pg_result* result) { Pq().clear(result); }

int Rows::count() const { return Pq().ntuples(result_.get()); }

bool Rows::IsNull(int row, int column) const {
  return Pq().getisnull(result_.get(), row, column) != 0;
}

std::string Rows::Text(int row, int column) const {
  return {Pq().getvalue(result_.get(), row, column),
          static_cast<std::size_t>(Pq().getlength(result_.get(), row, column))};
}

std::int64_t Rows::Integer(int row, int column) const {
  const std::string text = Text(row, column);
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::int64_t Rows::Changes() const {
  const std::string_view text = Pq().cmd_tuples(result_.get());
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

Result<std::unique_ptr<Session>> Session::Connect(const SessionOptions& options) {
  if (!Library()) return Fail(Library().error());
  std::string place = FormatPlace(options.url);
  pg_conn* const connection = Open(options);
  if (connection == nullptr) {
    return Fail(ErrorKind::kLedger, "no memory to connect to the ledger " + place);
  }
  std::unique_ptr<Session> session(new Session(connection, std::move(place)));
  if (Pq().status(connection) != CONNECTION_OK) {
    return Fail(CannotConnect(Pq().error_message(connection), session->place_));
  }
  Pq().set_notice_processor(
      connection, [](void*, const char*) {}, nullptr);
  Pq().set_nonblocking(connection, 1);
  Pq().enter_pipeline_mode(connection);
  return session;
}

Session::~Session() { Pq().finish(connection_); }

bool Session::Send(const Query& query) {
  std::vector<const char*> values;
  values.reserve(query.values.size());
  for (const auto& value : query.values) values.push_back(value ? value->c_str() : nullptr);
  const std::string sql(query.sql);
  return Pq().send_query_params(connection_, sql.c_str(), static_cast<int>(values.size()), nullptr,
                                values.data(), nullptr, nullptr, 0) == 1;
}

Status Session::SendAll(std::span<const Query> queries) {
  for (const Query& query : queries) {
    if (!Send(query)) return Fail(Lose());
  }
  if (Pq().pipeline_sync(connection_) != 1) return Fail(Lose());
  return {};
}

Result<std::vector<Rows>> Session::Run(std::span<const Query> queries, Deadline deadline) {
  state_.clear();
  if (lost_) return Fail(Lose());
  if (Status sent = SendAll(queries); !sent) return Fail(std::move(sent.error()));
  for (; posted_ > 0; --posted_) {
    // What was posted may fail: who posts does not care.
    if (auto ignored = ReadRetained(deadline); lost_) return ignored;
  }
  return ReadRetained(deadline);
}

Result<Rows> Session::Run(const Query& query, Deadline deadline) {
  auto all = Run(std::span(&query, 1), deadline);
  if (!all) return Fail(std::move(all.error()));
  return std::move(all->front());
}

void Session::Post(const Query& query) {
  if (lost_ || !SendAll(std::span(&query, 1))) return;
  ++posted_;
  Pq().flush(connection_);  // a few bytes into an idle socket
}

bool Session::IsQuiet() const {
  pollfd socket{.fd = Pq().socket(connection_), .events = POLLIN | POLLRDHUP, .revents = 0};
  return socket.fd >= 0 && poll(&socket, 1, 0) == 0;
}

// The answers up to the next synchronisation point, and the first error among them.
Result<std::vector<Rows>> Session::ReadRetained(Deadline deadline) {
  std::vector<Rows> all;
  std::optional<Error> error;
  while (true) {
    const Result<pg_result*> next = Await(deadline);
    if (!next) return Fail(error && !lost_ ? *error : next.error());
    if (*next == nullptr) {  // between two statements
      if (Pq().status(connection_) != CONNECTION_OK) return Fail(error ? *error : Lose());
      continue;
    }
    Rows rows(*next);
    switch (Pq().result_status(*next)) {
      case PGRES_PIPELINE_SYNC:
        if (error) return Fail(std::move(*error));
        return all;
      case PGRES_TUPLES_OK:
      case PGRES_COMMAND_OK:
        all.push_back(std::move(rows));
        break;
      case PGRES_PIPELINE_ABORTED:
        break;
      default:
        if (!error) error = Explain(*next);
        if (lost_) return Fail(std::move(*error));
    }
  }
}

Result<pg_result*> Session::Await(Deadline deadline) {
  const auto started = steady_clock::now();
  while (true) {
    const int unsent = Pq().flush(connection_);
    if (unsent < 0) return Fail(Lose());
    if (unsent == 0 && Pq().is_busy(connection_) == 0) return Pq().get_result(connection_);
    pollfd socket{.fd = Pq().socket(connection_), .events = POLLIN, .revents = 0};
    if (unsent > 0) socket.events |= POLLOUT;
    const int ready = poll(&socket, 1, LeftUntil(deadline));
    if (ready == 0) {
      lost_ = true;
      return Fail(ErrorKind::kLedger,
                  fmt::format("the ledger {} did not answer for {}", place_,
                              base::FormatElapsed(steady_clock::now() - started)));
    }
    if (ready > 0 && (socket.revents & ~POLLOUT) != 0 && Pq().consume_input(connection_) != 1) {
      return Fail(Lose());
    }
  }
}

Error Session::Lose() {
  lost_ = true;
  state_.clear();
  return ExplainPostgres("", Pq().error_message(connection_), place_);
}

Error Session::Explain(const pg_result* result) {
  const char* state = Pq().result_error_field(result, PG_DIAG_SQLSTATE);
  const char* text = Pq().result_error_field(result, PG_DIAG_MESSAGE_PRIMARY);
  state_ = state == nullptr ? "" : state;
  if (text == nullptr) text = Pq().result_error_message(result);
  if (state_.empty() || EndsTheConnection(state_)) lost_ = true;
  return ExplainPostgres(state_, text, place_);
}

}  // namespace fleetpub::ledger
