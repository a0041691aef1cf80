// A real aedes, for one test: a broker that is a library for Node.js.
#pragma once

#include <cstdint>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "support/process.h"

namespace fleetpub::testing {

/// tests/peers/aedes_broker.mjs, for MQTT and for WebSockets. Accepts connections when the
/// constructor returns; ends with this object.
class Aedes {
 public:
  /// Lets in everybody, or only this user.
  explicit Aedes(std::string user = {}, std::string password = {})
      : user_(std::move(user)), password_(std::move(password)) {
    Start();
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// `mqtt://127.0.0.1:port`, or `ws://…`.
  [[nodiscard]] std::string Url(std::string_view scheme = "mqtt") const {
    return std::string(scheme) +
           "://127.0.0.1:" + std::to_string(scheme == "ws" ? web_port_ : port_);
  }
  /// Kills it, and starts it again on the same ports, without what it had retained.
  void Restart() {
    process_->Signal(SIGKILL);
    static_cast<void>(process_->Wait());
    Start();
  }

 private:
  void Start() {
    Command command{.arguments = {"node", FLEETPUB_SOURCE_DIR "/tests/peers/aedes_broker.mjs",
                                  std::to_string(port_), std::to_string(web_port_)}};
    if (!user_.empty()) command.arguments.insert(command.arguments.end(), {user_, password_});
    process_ = std::make_unique<Process>(std::move(command));
    if (!process_->AwaitOutput("\n")) throw std::runtime_error("no aedes: " + process_->Errors());
    std::istringstream said(process_->Output().substr(std::string_view("listening on ").size()));
    said >> port_ >> web_port_;
  }

  std::string user_;
  std::string password_;
  std::unique_ptr<Process> process_;
  std::uint16_t port_ = 0;
  std::uint16_t web_port_ = 0;
};

}  // namespace fleetpub::testing
