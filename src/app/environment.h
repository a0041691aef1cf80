// What the use cases work with, besides their requests.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "app/observer.h"
#include "base/result.h"
#include "config/config.h"
#include "delivery/connect_hook.h"
#include "ledger/ledger.h"
#include "ledger/options.h"
#include "mqtt/transport.h"

namespace fleetpub::app {

/// How the broker is reached.
struct Connection {
  std::chrono::milliseconds timeout{10'000};  ///< to connect, and to acknowledge
  mqtt::ProtocolVersion version = mqtt::ProtocolVersion::k311;
  delivery::ConnectHook open;
};

/// Opens the ledger. Errors: ErrorKind::kUsage, kLedger.
using LedgerHook = std::function<Result<std::unique_ptr<ledger::Ledger>>(ledger::OpenMode mode)>;

struct Environment {
  const config::Config& config;
  std::string schema_directory;
  bool names_broker = false;  ///< somebody says which broker; else it is the default one
  std::string site;           ///< which, as a person reads it (FormatSite)
  /// Asked when a connection is needed: it may ask a person for a password. Errors: kUsage, kLedger.
  std::function<Result<Connection>()> connection;
  LedgerHook ledger;
};

/// An open connection; the transport is null while it is lost.
struct Link {
  Connection connection;
  std::unique_ptr<mqtt::Transport> transport;
};

/// `mqtts://north (profile north)`.
[[nodiscard]] std::string FormatSite(const mqtt::BrokerUrl& broker, const std::string& profile);

[[nodiscard]] Result<Link> Connect(const Environment& environment, Log& log);

}  // namespace fleetpub::app
