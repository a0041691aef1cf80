// MQTT 5's properties of a message as Paho takes them.
#pragma once

#include <MQTTClient.h>

#include <cstddef>

#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// Owns a copy of what it is made from. One thread at a time.
class PahoProperties {
 public:
  explicit PahoProperties(const PublishProperties& properties);
  PahoProperties(const PahoProperties&) = delete;
  PahoProperties& operator=(const PahoProperties&) = delete;
  ~PahoProperties();

  /// For MQTTClient_publish5, which copies what it keeps.
  [[nodiscard]] MQTTProperties* get() { return &list_; }
  /// Bytes of the list in a packet, without its own length.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(list_.length); }

 private:
  MQTTProperties list_ = MQTTProperties_initializer;
};

}  // namespace fleetpub::mqtt
