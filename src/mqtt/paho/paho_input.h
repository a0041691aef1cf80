// What Paho reads, for as long as one of these lives. See paho_input.cc.
#pragma once

#include <array>
#include <cstddef>

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

  /// Bytes have been read that Paho has not asked for yet: poll() knows nothing of them.
  [[nodiscard]] bool HasReadAhead() const { return ahead_at_ < ahead_end_; }
  [[nodiscard]] static bool HasReadAhead(int descriptor);

  [[nodiscard]] PacketCheck& check() { return gate_.check(); }
  [[nodiscard]] const std::string& fault() const { return gate_.fault(); }

 private:
  friend struct Input;

  [[nodiscard]] ssize_t Read(void* buffer, std::size_t size, const InputGate::Source& system);

  InputGate gate_;
  int descriptor_ = -1;
  std::array<char, 16'384> ahead_{};
  std::size_t ahead_at_ = 0;
  std::size_t ahead_end_ = 0;
};

}  // namespace fleetpub::mqtt
