// A real aedes, for one test: a broker that is a library for Node.js.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "support/process.h"

namespace fleetpub::testing {

/// tests/peers/aedes_broker.mjs. Accepts connections when the constructor returns; ends with this
/// object.
class Aedes {
 public:
  /// Lets in everybody, or only this user.
  explicit Aedes(const std::string& user = {}, const std::string& password = {})
      : process_({.arguments = user.empty() ? Script() : With(Script(), {user, password})}) {
    constexpr std::string_view kSays = "listening on ";
    if (!process_.AwaitOutput("\n")) throw std::runtime_error("no aedes: " + process_.Errors());
    port_ = static_cast<std::uint16_t>(std::stoi(process_.Output().substr(kSays.size())));
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::string Url() const { return "mqtt://127.0.0.1:" + std::to_string(port_); }

 private:
  static std::vector<std::string> Script() {
    return {"node", FLEETPUB_SOURCE_DIR "/tests/peers/aedes_broker.mjs"};
  }
  static std::vector<std::string> With(std::vector<std::string> all,
                                       const std::vector<std::string>& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  Process process_;
  std::uint16_t port_ = 0;
};

}  // namespace fleetpub::testing
