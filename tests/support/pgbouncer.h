// A real PgBouncer in front of a PostgreSQL, which it reaches over a single connection.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "support/postgres.h"
#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// Listens on a free port of 127.0.0.1 when the constructor returns; ends with this object.
class PgBouncer {
 public:
  /// `pool_mode` is `session` or `transaction`.
  PgBouncer(const Postgres& server, const std::string& pool_mode);

  [[nodiscard]] std::string Url() const;

 private:
  TemporaryFolder folder_;
  std::uint16_t port_ = 0;
  std::unique_ptr<Process> process_;
};

}  // namespace fleetpub::testing
