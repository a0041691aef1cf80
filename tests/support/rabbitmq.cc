#include "support/rabbitmq.h"

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "support/free_port.h"

namespace fleetpub::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// The script in PATH changes the user; this one is what it starts.
constexpr const char* kServer = "/usr/lib/rabbitmq/bin/rabbitmq-server";
constexpr int kAttempts = 3;
constexpr std::chrono::seconds kStartPatience{120};  // with other tests beside it
constexpr milliseconds kGlance{20};
constexpr const char* kProbe = "probe";

std::string Loopback(std::string_view scheme, std::uint16_t port) {
  return std::string(scheme) + "://127.0.0.1:" + std::to_string(port);
}

}  // namespace

RabbitMq::RabbitMq() {
  if (access(kServer, X_OK) != 0)
    throw std::runtime_error("RabbitMQ is not installed: " + std::string(kServer));
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    TakePorts();
    if (Start()) return;  // a port is taken by now, or once in thousands it stands still
  }
  throw std::runtime_error("RabbitMQ does not start: " + Log());
}

void RabbitMq::TakePorts() {
  server_.reset();
  mqtt_port_ = FreePort();
  web_port_ = FreePort();
  amqp_port_ = FreePort();
  names_port_ = FreePort();
  names_ = std::make_unique<Process>(Command{
      .arguments = {"epmd", "-port", std::to_string(names_port_), "-address", "127.0.0.1"}});
}

void RabbitMq::Restart() {
  server_->Signal(SIGKILL);
  static_cast<void>(server_->Wait());
  if (!Start()) throw std::runtime_error("RabbitMQ does not start again: " + Log());
}

// `RUNNING_UNDER_SYSTEMD` makes the script become the server, instead of staying as its parent: it
// is ended by our child's pid, and by the kernel when the test dies.
bool RabbitMq::Start() {
  const std::string names_port = std::to_string(names_port_);
  const auto config = folder_.Write(
      "rabbitmq.conf",
      "listeners.tcp.1 = 127.0.0.1:" + std::to_string(amqp_port_) +
          "\nmqtt.listeners.tcp.1 = 127.0.0.1:" + std::to_string(mqtt_port_) +
          "\nweb_mqtt.tcp.ip = 127.0.0.1\nweb_mqtt.tcp.port = " + std::to_string(web_port_) + "\n");
  const auto plugins = folder_.Write("enabled_plugins", "[rabbitmq_mqtt,rabbitmq_web_mqtt].\n");
  Command server{.arguments = {kServer}};
  server.environment = {
      {"HOME", folder_.path().string()},
      {"RUNNING_UNDER_SYSTEMD", "1"},
      {"NOTIFY_SOCKET", std::nullopt},
      {"RABBITMQ_NODENAME", "fleetpub" + names_port + "@localhost"},
      {"RABBITMQ_MNESIA_BASE", (folder_ / "mnesia").string()},
      {"RABBITMQ_LOG_BASE", (folder_ / "log").string()},
      {"RABBITMQ_LOGS", "-"},
      {"RABBITMQ_CONFIG_FILE", config.string()},
      {"RABBITMQ_ENABLED_PLUGINS_FILE", plugins.string()},
      {"RABBITMQ_DIST_PORT", std::to_string(FreePort())},
      {"RABBITMQ_PID_FILE", (folder_ / "pid").string()},
      {"ERL_EPMD_PORT", names_port},
      {"ERL_EPMD_ADDRESS", "127.0.0.1"},
  };
  server_ = std::make_unique<Process>(std::move(server));
  return server_->AwaitOutput("Server startup complete", kStartPatience);
}

RabbitMq& RabbitMq::Shared() {
  static RabbitMq broker;
  return broker;
}

std::string RabbitMq::Url(std::string_view scheme) const {
  return scheme == "ws" ? Loopback(scheme, web_port_) + "/ws" : Loopback(scheme, mqtt_port_);
}
std::string RabbitMq::AmqpUrl() const { return Loopback("amqp", amqp_port_); }
std::string RabbitMq::Log() const { return server_->Output() + server_->Errors(); }

void PublishOverAmqp(const RabbitMq& broker, const std::string& routing_key,
                     const std::string& body) {
  const Finished run = Run({.arguments = {"amqp-publish", "-u", broker.AmqpUrl(), "-e", "amq.topic",
                                          "-r", routing_key, "-b", body}});
  if (run.exit_code != 0) throw std::runtime_error("amqp-publish: " + run.errors);
}

AmqpConsumer::AmqpConsumer(const RabbitMq& broker, const std::string& routing_key) {
  // amqp-consume takes the options of a command for its own: the command is a script.
  const auto script = folder_.Write("line", "#!/bin/sh\ncat\necho\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  process_ = std::make_unique<Process>(
      Command{.arguments = {"amqp-consume", "-u", broker.AmqpUrl(), "-q", "fleetpub-test", "-e",
                            "amq.topic", "-r", routing_key, "-x", "-A", script.string()}});
  const auto deadline = steady_clock::now() + Process::kPatience;
  while (process_->Output().empty()) {
    if (steady_clock::now() > deadline || !process_->Running()) {
      throw std::runtime_error("amqp-consume receives nothing: " + process_->Errors());
    }
    PublishOverAmqp(broker, "soar.probe", kProbe);
    std::this_thread::sleep_for(kGlance);
  }
}

std::vector<std::string> AmqpConsumer::SoFar() const {
  std::vector<std::string> bodies;
  std::string output = process_->Output();
  output.resize(output.rfind('\n') + 1);
  std::istringstream stream(output);
  for (std::string line; std::getline(stream, line);) {
    if (line != kProbe) bodies.push_back(line);
  }
  return bodies;
}

std::vector<std::string> AmqpConsumer::Await(std::size_t count) const {
  const auto deadline = steady_clock::now() + Process::kPatience;
  auto bodies = SoFar();
  while (bodies.size() < count && steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kGlance);
    bodies = SoFar();
  }
  return bodies;
}

}  // namespace fleetpub::testing
