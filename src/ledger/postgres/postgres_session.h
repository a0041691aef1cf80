// libpq, thinly: one connection to PostgreSQL, and what is asked over it. Knows nothing of ledgers
// but how to tell a person what the database's words mean for one.
//
// libpq is loaded when the first Session connects, and stays: it brings a dozen libraries, and
// nobody else should pay for them. A static binary cannot load it and says so.
//
// A Session belongs to one thread. Errors are of ErrorKind::kLedger.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

struct pg_conn;
struct pg_result;

namespace fleetpub::ledger {

/// One statement; `$1` … are the values, NULL where there is none. Must outlive the call that takes
/// it.
struct Query {
  std::string_view sql;
  std::vector<std::optional<std::string>> values = {};
};

/// A value of type `text[]`, or of any array that its elements can be read as.
class ArrayText {
 public:
  void Add(std::string_view element);
  void AddNull();
  [[nodiscard]] std::string Take();

 private:
  std::string text_ = "{";
};

/// What a statement returned.
class Rows {
 public:
  explicit Rows(pg_result* result) : result_(result, &Clear) {}

  [[nodiscard]] int count() const;
  [[nodiscard]] bool IsNull(int row, int column) const;
  [[nodiscard]] std::string Text(int row, int column) const;
  /// 0 when the text is no number.
  [[nodiscard]] std::int64_t Integer(int row, int column) const;
  /// Rows that the statement changed.
  [[nodiscard]] std::int64_t Changes() const;

 private:
  static void Clear(pg_result* result);
  std::unique_ptr<pg_result, void (*)(pg_result*)> result_;
};

struct SessionOptions {
  std::string url;  ///< checked by CheckPostgresUrl
  /// Instead of what ~/.pgpass and the environment say.
  std::optional<std::string> password;
  std::string name;  ///< how the server's administrator sees us
  /// For each address of each host; libpq counts whole seconds, two at least. The name lookup has
  /// no limit.
  std::chrono::milliseconds connect_timeout{10'000};
  bool writable = true;  ///< of several hosts, take one that can be written
};

class Session {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  [[nodiscard]] static Result<std::unique_ptr<Session>> Connect(const SessionOptions& options);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// All statements in one round trip and one transaction (unless they say BEGIN themselves): all
  /// of them or none. Returns what each returned. Committed when it returns; when it fails and
  /// lost() says yes, nobody knows.
  [[nodiscard]] Result<std::vector<Rows>> Run(std::span<const Query> queries, Deadline deadline);
  [[nodiscard]] Result<Rows> Run(const Query& query, Deadline deadline);

  /// Sends a statement and awaits no answer: what comes after it waits.
  void Post(const Query& query);

  /// Of no further use: broken, ended by the server, or silent for too long.
  [[nodiscard]] bool lost() const { return lost_; }
  /// A glance at the socket. While nothing is asked the server says nothing, unless it ends.
  [[nodiscard]] bool IsQuiet() const;
  /// Of the last failed Run; empty when the connection failed.
  [[nodiscard]] const std::string& state() const { return state_; }
  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  Session(pg_conn* connection, std::string place)
      : connection_(connection), place_(std::move(place)) {}
  [[nodiscard]] bool Send(const Query& query);
  [[nodiscard]] Status SendAll(std::span<const Query> queries);
  [[nodiscard]] Result<std::vector<Rows>> ReadRetained(Deadline deadline);
  [[nodiscard]] Result<pg_result*> Await(Deadline deadline);
  [[nodiscard]] Error Lose();
  [[nodiscard]] Error Explain(const pg_result* result);

  pg_conn* connection_;
  std::string place_;
  std::string state_;
  int posted_ = 0;  // answers that nobody has read yet
  bool lost_ = false;
};

}  // namespace fleetpub::ledger
