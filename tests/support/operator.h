// What an end-to-end test has at hand: the real binary with a home of its own, and a real broker.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/rapidjson.h"
#include "support/mosquitto.h"
#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// The binary under test: $FLEETPUB_BINARY, or the one that was built with the tests.
[[nodiscard]] std::string Binary();

/// The call for robots that need not be there: these arguments with the version stated (3.0, unless
/// they state one) and no check, so that the broker is asked for nothing.
[[nodiscard]] std::vector<std::string> WithoutLook(std::vector<std::string> arguments);

/// Someone who calls fleetpub: a home folder, nothing else in the environment that it would heed.
class Operator {
 public:
  /// The command for `fleetpub ARGUMENTS…`, to be changed or started in the background.
  [[nodiscard]] Command Prepare(std::vector<std::string> arguments) const;
  /// Runs it to its end.
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const;
  /// The same WithoutLook().
  [[nodiscard]] Finished Send(std::vector<std::string> arguments) const {
    return Fleetpub(WithoutLook(std::move(arguments)));
  }

  [[nodiscard]] const TemporaryFolder& home() const { return home_; }
  /// Where the ledger is when nobody says otherwise.
  [[nodiscard]] std::filesystem::path LedgerPath() const;
  /// From now on every call uses this broker.
  void UseBroker(std::string url) { broker_ = std::move(url); }
  /// And this ledger; nothing: what the configuration says.
  void UseLedger(std::optional<std::string> place) { ledger_ = std::move(place); }

 private:
  TemporaryFolder home_;
  std::string broker_;
  std::optional<std::string> ledger_ = LedgerPath().string();
};

/// Listens with mosquitto_sub, a client that we did not write.
class Subscriber {
 public:
  /// Returns once the broker has acknowledged the subscription.
  explicit Subscriber(const Mosquitto& broker, const std::string& filter = "#", int qos = 0)
      : Subscriber(broker.port(), filter, qos) {}
  /// At the broker on this port of 127.0.0.1.
  Subscriber(std::uint16_t port, const std::string& filter, int qos);

  /// A received message: `RETAINED QOS TOPIC PAYLOAD`, as mosquitto_sub saw it.
  struct Received {
    bool retained = false;
    int qos = 0;
    std::string topic;
    std::string payload;
  };
  /// The first `count` messages; fewer when no more come in time.
  [[nodiscard]] std::vector<Received> Await(std::size_t count) const;
  [[nodiscard]] std::vector<Received> SoFar() const;
  /// Whether a message with this payload comes in time.
  [[nodiscard]] bool AwaitPayload(std::string_view payload) const {
    return process_->AwaitOutput(" " + std::string(payload) + "\n");
  }

 private:
  std::unique_ptr<Process> process_;
};

/// Operator and broker together.
class EndToEnd : public ::testing::Test {
 protected:
  EndToEnd() { operator_.UseBroker(broker_.Url()); }
  [[nodiscard]] Finished Fleetpub(std::vector<std::string> arguments) const {
    return operator_.Fleetpub(std::move(arguments));
  }
  /// To robots that need not be there.
  [[nodiscard]] Finished Send(std::vector<std::string> arguments) const {
    return operator_.Send(std::move(arguments));
  }
  /// `fleetpub simulate ARGUMENTS…`, online when this returns.
  [[nodiscard]] std::unique_ptr<Process> Robot(std::vector<std::string> arguments) const;
  /// Publishes what a robot that the test plays by hand says.
  void Say(const std::string& topic, const std::string& payload, bool retained) const;

  Mosquitto broker_;
  Operator operator_;
};

/// The text as JSON; the test fails when it is none.
[[nodiscard]] base::JsonDocument Json(std::string_view text);
[[nodiscard]] std::vector<std::string> Lines(std::string_view text);

}  // namespace fleetpub::testing
