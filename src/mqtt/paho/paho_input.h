// What Paho reads, for as long as one of these lives. See paho_input.cc.
#pragma once

#include <cstddef>
#include <memory>

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

  /// What Paho gets for its recv() and its SSL_read(), out of what the system and the library bring.
  [[nodiscard]] ssize_t Receive(void* buffer, std::size_t size, const InputGate::Source& system);
  [[nodiscard]] ssize_t Decrypt(void* buffer, std::size_t size, const InputGate::Source& library);

  [[nodiscard]] PacketCheck& check() { return gate_.check(); }
  [[nodiscard]] const std::string& fault() const { return gate_.fault(); }

 private:
  friend struct Input;

  static constexpr std::size_t kMostAhead = 16'384;

  [[nodiscard]] ssize_t ReceiveAhead(void* buffer, std::size_t size,
                                     const InputGate::Source& system);

  InputGate gate_;
  int descriptor_ = -1;
  /// Not filled: of its pages only those are touched that are read into.
  std::unique_ptr<char[]> ahead_ = std::make_unique_for_overwrite<char[]>(kMostAhead);
  std::size_t ahead_at_ = 0;
  std::size_t ahead_end_ = 0;
};

}  // namespace fleetpub::mqtt
