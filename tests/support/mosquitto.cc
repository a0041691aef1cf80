#include "support/mosquitto.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "support/free_port.h"

namespace fleetpub::testing {
namespace {

constexpr int kAttempts = 5;
// Debian keeps it where only root's PATH leads.
constexpr const char* kProgram = "/usr/sbin/mosquitto";

std::string Program() { return access(kProgram, X_OK) == 0 ? kProgram : "mosquitto"; }

std::string Filled(std::string line, const std::string& folder) {
  for (std::size_t at = 0; (at = line.find("{}", at)) != std::string::npos; at += folder.size()) {
    line.replace(at, 2, folder);
  }
  return line;
}

}  // namespace

Mosquitto::Mosquitto(std::vector<std::string> lines,
                     const std::vector<std::pair<std::string, std::string>>& files)
    : lines_(std::move(lines)) {
  for (const auto& [name, content] : files) folder_.Write(name, content);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    port_ = FreePort();
    if (Start()) return;
    if (Log().find("Address already in use") == std::string::npos) break;
  }
  throw std::runtime_error("mosquitto does not start: " + Log());
}

bool Mosquitto::Start() {
  std::ostringstream config;
  // As root it would change its user, which makes the kernel forget that it is to die with us.
  if (geteuid() == 0) config << "user root\n";
  config << "persistence false\nlog_dest stderr\nlog_type all\n";
  // 2.0.11 does not start with nothing but a WebSocket.
  if (std::find(lines_.begin(), lines_.end(), "protocol websockets") != lines_.end()) {
    config << "listener 0 " << (folder_ / "socket").string() << '\n';
  }
  config << "listener " << port_ << " 127.0.0.1\n";
  for (const std::string& line : lines_) config << Filled(line, folder_.path().string()) << '\n';
  const auto file = folder_.Write("mosquitto.conf", config.str());
  process_ = std::make_unique<Process>(Command{.arguments = {Program(), "-c", file.string()}});
  // It says so when its sockets listen. A successful connect() would prove less: it could be
  // another program's port.
  return process_->AwaitErrors(" running");
}

std::string Mosquitto::Url(std::string_view scheme, std::string_view host) const {
  return std::string(scheme) + "://" + std::string(host) + ":" + std::to_string(port_);
}

bool Mosquitto::AwaitSubscription(std::string_view filter) {
  if (!AwaitLog(filter)) return false;
  // It answers one packet after the other: what it sends a newcomer leaves behind the SUBACK.
  return Run({.arguments = {"mosquitto_sub", "-p", std::to_string(port_), "-t", "none", "-E"}})
             .exit_code == 0;
}

void Mosquitto::Kill() {
  process_->Signal(SIGKILL);
  static_cast<void>(process_->Wait());
}

void Mosquitto::Restart() {
  Kill();
  if (!Start()) throw std::runtime_error("mosquitto does not start again: " + Log());
}

std::string PasswordFile(const std::string& user, const std::string& password) {
  const TemporaryFolder folder;
  const auto file = folder.Write("passwords", "");
  const Finished made =
      Run({.arguments = {"mosquitto_passwd", "-b", file.string(), user, password}});
  if (made.exit_code != 0) throw std::runtime_error("mosquitto_passwd: " + made.errors);
  std::ostringstream content;
  content << std::ifstream(file).rdbuf();
  return content.str();
}

}  // namespace fleetpub::testing
