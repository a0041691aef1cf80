// A real PostgreSQL, for one test or for all tests of a program.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// PostgreSQL's programs refuse to be root: as nobody then, and ending with this process.
[[nodiscard]] std::vector<std::string> AsOrdinaryUser(std::vector<std::string> command);

/// Listens on a free port of 127.0.0.1 and accepts connections when the constructor returns; ends
/// with this object. Its superuser is `postgres`, whom it trusts. Runs as an ordinary user, since
/// it refuses to be root. Does not wait for the disk.
class Postgres {
 public:
  Postgres();
  Postgres(const Postgres&) = delete;
  Postgres& operator=(const Postgres&) = delete;
  ~Postgres();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// `postgresql://postgres@127.0.0.1:port/database`
  [[nodiscard]] std::string Url(std::string_view database = "postgres",
                                std::string_view user = "postgres",
                                std::string_view host = "127.0.0.1") const;
  /// A new database, and its URL.
  [[nodiscard]] std::string MakeDatabase();
  /// What psql prints, one line per row. Throws when it fails.
  std::string Sql(const std::string& url, const std::string& sql) const;
  /// Before everything else in pg_hba.conf; in force when this returns.
  void Authenticate(const std::string& lines);
  /// Lines of postgresql.conf, and files of the data folder for them; restarts it.
  void Configure(const std::string& lines,
                 const std::vector<std::pair<std::string, std::string>>& files);

  /// Ends it as `systemctl stop` does: connections are closed.
  void Stop();
  void Start();
  void Restart() {
    Stop();
    Start();
  }
  [[nodiscard]] Process& process() { return *process_; }

 private:
  [[nodiscard]] bool TryStart();
  /// A file that its user can read and nobody else.
  void WriteData(const std::string& name, const std::string& content) const;

  TemporaryFolder folder_;
  std::uint16_t port_ = 0;
  int databases_ = 0;
  std::string trust_;
  std::unique_ptr<Process> process_;
};

}  // namespace fleetpub::testing
