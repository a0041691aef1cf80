// A real mosquitto, for one test.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// Listens on a free port of 127.0.0.1 and accepts connections when the constructor returns; ends
/// with this object.
class Mosquitto {
 public:
  /// Everybody may do everything.
  Mosquitto() : Mosquitto(std::vector<std::string>{"allow_anonymous true"}) {}
  /// With these lines of configuration for its one listener. `{}` in them is its folder, for which
  /// see Write().
  explicit Mosquitto(std::vector<std::string> lines,
                     const std::vector<std::pair<std::string, std::string>>& files = {});

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// `mqtt://127.0.0.1:port`, or another scheme.
  [[nodiscard]] std::string Url(std::string_view scheme = "mqtt",
                                std::string_view host = "127.0.0.1") const;
  /// What it logged so far, all types.
  [[nodiscard]] std::string Log() const { return process_->Errors(); }
  [[nodiscard]] bool AwaitLog(std::string_view text) { return process_->AwaitErrors(text); }
  /// Whether it logs `filter` of a subscription in time; its SUBACK has left by then. The log alone
  /// is written before.
  [[nodiscard]] bool AwaitSubscription(std::string_view filter);
  [[nodiscard]] Process& process() { return *process_; }

  /// Ends it without a word to its clients.
  void Kill();
  /// Starts it again, on the same port.
  void Restart();

 private:
  [[nodiscard]] bool Start();

  TemporaryFolder folder_;
  std::vector<std::string> lines_;
  std::uint16_t port_ = 0;
  std::unique_ptr<Process> process_;
};

/// A mosquitto password file with this one user, made by mosquitto_passwd.
[[nodiscard]] std::string PasswordFile(const std::string& user, const std::string& password);

}  // namespace fleetpub::testing
