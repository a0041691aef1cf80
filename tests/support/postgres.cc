#include "support/postgres.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "support/free_port.h"

namespace fleetpub::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kAttempts = 5;
constexpr std::chrono::seconds kPatience{60};  // with other tests beside it
constexpr unsigned kNobody = 65534;

/// Debian keeps the server's programs out of PATH, one folder per version.
std::string Program(const std::string& name) {
  const fs::path versions = "/usr/lib/postgresql";
  std::vector<fs::path> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(versions, none)) {
    if (access((entry.path() / "bin" / name).c_str(), X_OK) == 0) found.push_back(entry.path());
  }
  if (found.empty()) return name;
  return (*std::max_element(found.begin(), found.end()) / "bin" / name).string();
}

}  // namespace

std::vector<std::string> AsOrdinaryUser(std::vector<std::string> command) {
  // A change of the user makes the kernel forget that the process is to die with us.
  std::vector<std::string> prefix = {"setpriv", "--pdeathsig", "QUIT"};
  if (geteuid() == 0) {
    const std::string nobody = std::to_string(kNobody);
    prefix.insert(prefix.end(), {"--reuid", nobody, "--regid", nobody, "--clear-groups"});
  }
  command.insert(command.begin(), prefix.begin(), prefix.end());
  return command;
}

Postgres::Postgres() {
  chmod(folder_.path().c_str(), 0711);  // its data lie below and are another user's
  const std::string data = folder_ / "data";
  fs::create_directory(data);
  chmod(data.c_str(), 0700);
  if (geteuid() == 0 && chown(data.c_str(), kNobody, kNobody) != 0) {
    throw std::runtime_error("chown");
  }
  const Finished made =
      Run({.arguments = AsOrdinaryUser({Program("initdb"), "-D", data, "-U", "postgres", "-A",
                                        "trust", "-E", "UTF8", "--locale=C", "--no-sync",
                                        "--no-instructions", "--wal-segsize=1"}),
           .folder = "/"},
          kPatience);
  if (made.exit_code != 0) throw std::runtime_error("initdb: " + made.errors + made.output);
  trust_ = "host all all 127.0.0.1/32 trust\n";
  WriteData("pg_hba.conf", trust_);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    port_ = FreePort();
    if (TryStart()) return;
  }
  throw std::runtime_error("PostgreSQL does not start: " + process_->Errors());
}

Postgres::~Postgres() {
  if (!process_) return;
  process_->Signal(SIGQUIT);  // at once, but with its shared memory given back
  static_cast<void>(process_->Wait(kPatience));
}

void Postgres::WriteData(const std::string& name, const std::string& content) const {
  const auto file = folder_.Write("data/" + name, content);
  chmod(file.c_str(), 0600);
  if (geteuid() == 0 && chown(file.c_str(), kNobody, kNobody) != 0) {
    throw std::runtime_error("chown");
  }
}

bool Postgres::TryStart() {
  Command command{.arguments = AsOrdinaryUser(
                      {Program("postgres"), "-D", folder_ / "data", "-p", std::to_string(port_),
                       "-c", "listen_addresses=127.0.0.1", "-c", "unix_socket_directories=", "-c",
                       "fsync=off", "-c", "full_page_writes=off", "-c", "shared_buffers=16MB", "-c",
                       "logging_collector=off", "-c", "log_destination=stderr"}),
                  .folder = "/"};
  command.environment = {{"LC_ALL", "C"}};
  process_ = std::make_unique<Process>(std::move(command));
  return process_->AwaitErrors("ready to accept connections", kPatience);
}

void Postgres::Start() {
  if (!TryStart()) throw std::runtime_error("PostgreSQL does not start: " + process_->Errors());
}

void Postgres::Stop() {
  process_->Signal(SIGINT);  // "fast": PostgreSQL, §19.5
  static_cast<void>(process_->Wait(kPatience));
}

std::string Postgres::Url(std::string_view database, std::string_view user,
                          std::string_view host) const {
  return "postgresql://" + std::string(user) + "@" + std::string(host) + ":" +
         std::to_string(port_) + "/" + std::string(database);
}

std::string Postgres::MakeDatabase() {
  const std::string name = "ledger" + std::to_string(++databases_);
  Sql(Url(), "CREATE DATABASE " + name);
  return Url(name);
}

std::string Postgres::Sql(const std::string& url, const std::string& sql) const {
  const Finished ran = testing::Run({.arguments = {Program("psql"), "-X", "-q", "-A", "-t", "-v",
                                                   "ON_ERROR_STOP=1", "-d", url, "-c", sql}},
                                    kPatience);
  if (ran.exit_code != 0) throw std::runtime_error("psql: " + ran.errors);
  return ran.output;
}

void Postgres::Authenticate(const std::string& lines) {
  WriteData("pg_hba.conf", lines + trust_);
  Sql(Url(), "SELECT pg_reload_conf()");
  // The server reads it when it sees the signal; a session that begins later is asked by it.
  while (Sql(Url(), "SELECT count(*) FROM pg_hba_file_rules").substr(0, 1) !=
         std::to_string(1 + std::count(lines.begin(), lines.end(), '\n'))) {
  }
}

void Postgres::Configure(const std::string& lines,
                         const std::vector<std::pair<std::string, std::string>>& files) {
  for (const auto& [name, content] : files) WriteData(name, content);
  WriteData("postgresql.auto.conf", lines);
  Restart();
}

}  // namespace fleetpub::testing
