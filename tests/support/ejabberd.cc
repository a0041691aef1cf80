#include "support/ejabberd.h"

#include <fmt/format.h>
#include <glob.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "support/free_port.h"

namespace fleetpub::testing {
namespace {

constexpr int kAttempts = 3;
constexpr std::chrono::seconds kStartPatience{120};  // with other tests beside it

// `match_retained_limit` is 1,000 otherwise: larger fleets are cut off.
constexpr const char* kConfiguration = R"(hosts: [localhost]
auth_method: [anonymous]
anonymous_protocol: login_anon
listen:
  - port: {0}
    ip: "127.0.0.1"
    module: mod_mqtt
    max_payload_size: {3}
  - port: {1}
    ip: "127.0.0.1"
    module: ejabberd_http
    request_handlers:
      /mqtt: mod_mqtt
modules:
  mod_mqtt:
    match_retained_limit: infinity
{2})";

// Where Debian keeps the libraries of Erlang packages, whatever the processor.
std::string Libraries() {
  glob_t found{};
  std::string folder;
  if (glob("/usr/lib/*/ejabberd-*", 0, nullptr, &found) == 0) {
    folder = std::filesystem::path(found.gl_pathv[0]).parent_path().string();
  }
  globfree(&found);
  if (folder.empty()) throw std::runtime_error("ejabberd is not installed");
  return folder;
}

// Asked for while it reads its configuration: no name server is, and no program that asks one.
std::string NamesOfThisMachine() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) throw std::runtime_error("no host name");
  return fmt::format("{{lookup, [file]}}.\n{{host, {{127,0,0,1}}, [\"localhost\", \"{}\"]}}.\n",
                     name.data());
}

}  // namespace

Ejabberd::Ejabberd(std::string lines) : lines_(std::move(lines)) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    mqtt_port_ = FreePort();
    web_port_ = FreePort();
    if (Start()) return;  // once in thousands its start stands still, without a word
  }
  throw std::runtime_error("ejabberd does not start: " + Log());
}

// ejabberdctl would run it as a user of its own, and under a name, which takes a name daemon (epmd)
// on a fixed port. Without a name it needs neither.
bool Ejabberd::Start() {
  server_.reset();
  const auto config = folder_.Write(
      "ejabberd.yml", fmt::format(kConfiguration, mqtt_port_, web_port_, lines_, kMaximumPayload));
  Command server{.arguments = {"erl", "-noinput", "-mnesia", "dir",
                               fmt::format("\"{}\"", (folder_ / "database").string()), "-s",
                               "ejabberd"}};
  server.environment = {
      {"HOME", folder_.path().string()},
      {"NOTIFY_SOCKET", std::nullopt},
      {"ERL_LIBS", Libraries()},
      {"ERL_INETRC", folder_.Write("inetrc", NamesOfThisMachine()).string()},
      {"ERL_CRASH_DUMP", (folder_ / "crash").string()},
      {"EJABBERD_CONFIG_PATH", config.string()},
      {"EJABBERD_LOG_PATH", (folder_ / "ejabberd.log").string()},
  };
  server_ = std::make_unique<Process>(std::move(server));
  const auto listens = [this](std::uint16_t port) {
    return server_->AwaitOutput(fmt::format("connections at 127.0.0.1:{} ", port), kStartPatience);
  };
  return listens(mqtt_port_) && listens(web_port_);
}

std::string Ejabberd::Url(std::string_view scheme) const {
  return scheme == "ws" ? fmt::format("ws://fleetpub@127.0.0.1:{}/mqtt", web_port_)
                        : fmt::format("{}://fleetpub@127.0.0.1:{}", scheme, mqtt_port_);
}

void Ejabberd::Restart() {
  server_->Signal(SIGKILL);
  static_cast<void>(server_->Wait());
  if (!Start()) throw std::runtime_error("ejabberd does not start again: " + Log());
}

}  // namespace fleetpub::testing
