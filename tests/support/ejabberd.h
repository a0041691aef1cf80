// A real ejabberd with its MQTT module: a broker that wants a name and a password of everybody.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// Listens on free ports of 127.0.0.1, for MQTT and for WebSockets, and lets in whoever gives any
/// name and password. Accepts connections when the constructor returns, which takes about a second;
/// ends with this object. Throws std::runtime_error when it cannot be started.
class Ejabberd {
 public:
  static constexpr int kMaximumPayload = 1'000'000;

  /// With these lines for its module, indented by four spaces.
  explicit Ejabberd(std::string lines = {});

  /// `mqtt://fleetpub@127.0.0.1:port`, or `ws://…/mqtt`.
  [[nodiscard]] std::string Url(std::string_view scheme) const;
  [[nodiscard]] std::string Log() const { return server_->Output() + server_->Errors(); }
  /// Kills it, and starts it again on the same ports.
  void Restart();

 private:
  [[nodiscard]] bool Start();

  TemporaryFolder folder_;
  std::string lines_;
  std::uint16_t mqtt_port_ = 0;
  std::uint16_t web_port_ = 0;
  std::unique_ptr<Process> server_;
};

}  // namespace fleetpub::testing
