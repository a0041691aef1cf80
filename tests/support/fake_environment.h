// The world that a use case works in: a broker and a ledger that are not there.
#pragma once

#include <memory>
#include <optional>

#include "app/environment.h"
#include "support/fake_ledger.h"
#include "support/fake_transport.h"

namespace fleetpub::testing {

class FakeEnvironment {
 public:
  config::Config config;
  Journal journal;
  /// Readies each connection that is opened.
  std::function<void(FakeTransport&)> on_connect = [](FakeTransport&) {};
  std::optional<Error> connect_error;
  int connections = 0;
  int ledgers = 0;  ///< opened to record something
  bool names_broker = false;

  app::Environment Get() {
    return {.config = config,
            .schema_directory = "",
            .names_broker = names_broker,
            .site = "mqtt://broker",
            .connection = [this]() -> Result<app::Connection> {
              return app::Connection{.open = [this](mqtt::Deadline) { return Open(); }};
            },
            .ledger = [this](ledger::OpenMode mode) -> Result<std::unique_ptr<ledger::Ledger>> {
              if (mode == ledger::OpenMode::kCreate) ++ledgers;
              return std::make_unique<FakeLedger>(journal);
            }};
  }

 private:
  Result<std::unique_ptr<mqtt::Transport>> Open() {
    if (connect_error) return Fail(*connect_error);
    ++connections;
    auto transport = std::make_unique<FakeTransport>(journal);
    on_connect(*transport);
    return transport;
  }
};

}  // namespace fleetpub::testing
