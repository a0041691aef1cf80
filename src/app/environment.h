// What the use cases work with, besides their requests.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "app/observer.h"
#include "base/result.h"
#include "config/config.h"
#include "delivery/played_recording.h"
#include "delivery/reconnect.h"
#include "delivery/retained.h"
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
  /// Read in the broker's place, which is asked for nothing then; null: none is.
  std::shared_ptr<delivery::PlayedRecording> recording = {};
  /// Asked when a connection is needed: it may ask a person for a password. Errors: kUsage, kLedger.
  std::function<Result<Connection>()> connection;
  LedgerHook ledger;

  /// The time of what is read.
  [[nodiscard]] base::WallTime Now() const {
    return recording ? recording->now() : base::WallTime::clock::now();
  }
};

/// An open connection; the transport is null while it is lost.
struct Link {
  Connection connection;
  std::unique_ptr<mqtt::Transport> transport;
};

/// `mqtts://north (profile north)`.
[[nodiscard]] std::string FormatSite(const mqtt::BrokerUrl& broker, const std::string& profile);

/// For what is read from a recording: it is never silent, and it ends.
inline constexpr std::chrono::milliseconds kUntilItEnds = std::chrono::hours(24);
[[nodiscard]] inline delivery::RetainedOptions PatientOptions() {
  return {.quiet = kUntilItEnds, .most = kUntilItEnds};
}

[[nodiscard]] Result<Link> Connect(const Environment& environment, Log& log);

/// Opens a connection again when it is lost, and warns of that. The log must outlive it.
[[nodiscard]] delivery::ReconnectHooks MakeReconnectHooks(const Connection& connection, Log& log);

}  // namespace fleetpub::app
