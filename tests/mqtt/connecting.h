// What the tests of this folder share.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "mqtt/paho/paho_sockets.h"
#include "mqtt/paho/paho_transport.h"
#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// For what a build without FLEETPUB_FAST_CONNECT does not promise: exact deadlines and causes.
#define FLEETPUB_NEEDS_FAST_CONNECT() \
  if (!PahoCall::Supported()) GTEST_SKIP() << "FLEETPUB_FAST_CONNECT is off"

inline Deadline In(std::chrono::milliseconds time) {
  return std::chrono::steady_clock::now() + time;
}
/// For what happens at once, on however slow a machine.
inline Deadline Soon() { return In(std::chrono::seconds(15)); }

inline ConnectOptions To(const std::string& url) {
  ConnectOptions options;
  auto broker = ParseBrokerUrl(url);
  if (!broker) throw std::invalid_argument(broker.error().message);
  options.brokers.push_back(*std::move(broker));
  return options;
}

inline ConnectOptions V5(ConnectOptions options) {
  options.version = ProtocolVersion::k5;
  return options;
}

/// A connection that the test cannot do without.
inline std::unique_ptr<Transport> Connected(const ConnectOptions& options) {
  auto connection = ConnectPaho(options);
  if (!connection) throw std::runtime_error(connection.error().message);
  return *std::move(connection);
}

/// The error of a connection that must fail.
inline Error Refusal(const ConnectOptions& options) {
  auto connection = ConnectPaho(options);
  return connection ? Error{ErrorKind::kUnexpected, "connected"} : connection.error();
}

inline void MustSubscribe(Transport& transport, const std::string& filter,
                          Qos qos = Qos::kAtMostOnce) {
  const std::string filters[] = {filter};
  const auto status = transport.Subscribe(filters, qos, Soon());
  if (!status) throw std::runtime_error(status.error().message);
}

/// The next message, which must come.
inline Message MustReceive(Transport& transport) {
  auto message = transport.Receive(Soon());
  if (!message) throw std::runtime_error(message.error().message);
  if (!*message) throw std::runtime_error("no message");
  return **std::move(message);
}

}  // namespace fleetpub::mqtt
