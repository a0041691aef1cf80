// What Paho reads, for as long as one of these lives. See paho_input.cc.
#pragma once

#include "mqtt/input_gate.h"

namespace fleetpub::mqtt {

/// The input of one connection of Paho. Made, used and destroyed with PahoMutex() held.
class PahoInput {
 public:
  PahoInput(ProtocolVersion version, Framing framing);
  PahoInput(const PahoInput&) = delete;
  PahoInput& operator=(const PahoInput&) = delete;
  ~PahoInput();

  /// From now on this descriptor's input is this one, and no other's.
  void Bind(int descriptor);

  [[nodiscard]] PacketCheck& check() { return gate_.check(); }
  [[nodiscard]] const std::string& fault() const { return gate_.fault(); }

 private:
  friend struct Input;

  InputGate gate_;
  int descriptor_ = -1;
};

}  // namespace fleetpub::mqtt
