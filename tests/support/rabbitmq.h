// A real RabbitMQ with its MQTT plugin: the kind of backbone that SoAR runs on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "support/process.h"
#include "support/temporary_folder.h"

namespace fleetpub::testing {

/// Listens on free ports of 127.0.0.1, for MQTT, WebSockets and AMQP, and accepts connections from
/// everybody when the constructor returns, which takes some ten seconds. Has a name daemon (epmd)
/// of its own. Both end with this object. Throws std::runtime_error when it cannot be started.
class RabbitMq {
 public:
  RabbitMq();
  /// The one of this test program, started when it is first asked for.
  [[nodiscard]] static RabbitMq& Shared();

  [[nodiscard]] std::uint16_t mqtt_port() const { return mqtt_port_; }
  /// `mqtt://127.0.0.1:port`, or `ws://…/ws`.
  [[nodiscard]] std::string Url(std::string_view scheme = "mqtt") const;
  /// `amqp://127.0.0.1:port`
  [[nodiscard]] std::string AmqpUrl() const;
  [[nodiscard]] std::string Log() const;
  /// Kills it, and starts it again on the same ports.
  void Restart();

 private:
  void TakePorts();
  [[nodiscard]] bool Start();

  TemporaryFolder folder_;
  std::uint16_t mqtt_port_ = 0;
  std::uint16_t web_port_ = 0;
  std::uint16_t amqp_port_ = 0;
  std::uint16_t names_port_ = 0;
  // The server ends before the daemon that it is registered with.
  std::unique_ptr<Process> names_;
  std::unique_ptr<Process> server_;
};

/// Publishes over AMQP to the exchange `amq.topic`, with amqp-publish.
void PublishOverAmqp(const RabbitMq& broker, const std::string& routing_key,
                     const std::string& body);

/// A queue bound to `amq.topic`, read with amqp-consume: an AMQP client that we did not write.
class AmqpConsumer {
 public:
  /// Returns once messages arrive. `routing_key` may hold wildcards and must match
  /// `soar.probe`, a message by which that is found out.
  AmqpConsumer(const RabbitMq& broker, const std::string& routing_key);

  /// The bodies of the first `count` messages; fewer when no more come in time.
  [[nodiscard]] std::vector<std::string> Await(std::size_t count) const;

 private:
  [[nodiscard]] std::vector<std::string> SoFar() const;

  TemporaryFolder folder_;
  std::unique_ptr<Process> process_;
};

}  // namespace fleetpub::testing
