// What every ledger promises is tested against every kind of ledger.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "ledger/ledger_support.h"
#include "ledger/postgres/postgres_ledger.h"
#include "support/postgres.h"

namespace fleetpub::ledger {

enum class Kind { kSqlite, kPostgres };

/// One server for all tests of the program; each gets a database of its own.
inline testing::Postgres& Server() {
  static testing::Postgres server;
  return server;
}

inline PostgresOptions PostgresOptionsFor(const std::string& url, const Options& who) {
  PostgresOptions options;
  static_cast<Options&>(options) = who;
  options.url = url;
  return options;
}

/// Where a ledger is, or will be.
struct Place {
  Kind kind = Kind::kSqlite;
  std::string where;

  [[nodiscard]] Result<std::unique_ptr<Ledger>> Open(OpenMode mode = OpenMode::kCreate,
                                                     const Options& who = OptionsFor("")) const {
    if (kind == Kind::kPostgres) return OpenPostgres(PostgresOptionsFor(where, who), mode);
    SqliteOptions options = OptionsFor(where);
    static_cast<Options&>(options) = who;
    return OpenSqlite(std::move(options), mode);
  }

  [[nodiscard]] std::unique_ptr<Ledger> MustOpen(OpenMode mode = OpenMode::kCreate,
                                                 const Options& who = OptionsFor("")) const {
    auto ledger = Open(mode, who);
    if (!ledger) throw std::runtime_error(ledger.error().message + " " + ledger.error().detail);
    return std::move(*ledger);
  }
};

class Contract : public ::testing::TestWithParam<Kind> {
 protected:
  /// Where no ledger has been before.
  [[nodiscard]] Place NewPlace() {
    if (GetParam() == Kind::kPostgres) return {GetParam(), Server().MakeDatabase()};
    return {GetParam(), *folder_ / (std::to_string(++places_) + "/ledger.db")};
  }
  [[nodiscard]] static bool IsSqlite() { return GetParam() == Kind::kSqlite; }

  std::unique_ptr<testing::TemporaryFolder> folder_ = FastFolder();
  int places_ = 0;
  Place place_ = NewPlace();
};

inline std::string GetName(const ::testing::TestParamInfo<Kind>& kind) {
  return kind.param == Kind::kSqlite ? "Sqlite" : "Postgres";
}

/// `On/HeaderIds.BeginAtZero…/Sqlite`, `…/Postgres`.
#define FLEETPUB_FOR_EACH_LEDGER(Fixture) \
  INSTANTIATE_TEST_SUITE_P(On, Fixture, ::testing::Values(Kind::kSqlite, Kind::kPostgres), GetName)

}  // namespace fleetpub::ledger
