#include "support/pgbouncer.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <stdexcept>

#include "support/free_port.h"

namespace fleetpub::testing {
namespace {

constexpr int kAttempts = 5;

std::string Program() {
  // Debian keeps it out of an ordinary user's PATH.
  return std::filesystem::exists("/usr/sbin/pgbouncer") ? "/usr/sbin/pgbouncer" : "pgbouncer";
}

}  // namespace

PgBouncer::PgBouncer(const Postgres& server, const std::string& pool_mode) {
  chmod(folder_.path().c_str(), 0755);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    port_ = FreePort();
    const auto file = folder_.Write(
        "pgbouncer.ini",
        fmt::format("[databases]\n* = host=127.0.0.1 port={} user=postgres\n[pgbouncer]\n"
                    "listen_addr = 127.0.0.1\nlisten_port = {}\nunix_socket_dir =\n"
                    "auth_type = any\npool_mode = {}\ndefault_pool_size = 1\n",
                    server.port(), port_, pool_mode));
    chmod(file.c_str(), 0644);
    process_ = std::make_unique<Process>(
        Command{.arguments = AsOrdinaryUser({Program(), file}), .folder = "/"});
    if (process_->AwaitErrors("process up", std::chrono::seconds(30))) return;
  }
  throw std::runtime_error("PgBouncer does not start: " + process_->Errors());
}

std::string PgBouncer::Url() const {
  return fmt::format("postgresql://postgres@127.0.0.1:{}/postgres", port_);
}

}  // namespace fleetpub::testing
