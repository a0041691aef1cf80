// Between a connection and Paho: lets through what PacketCheck admits, and nothing else.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "mqtt/packet_check.h"

namespace fleetpub::mqtt {

/// How packets lie in what a connection brings.
enum class Framing { kNone, kWebSocket };

/// For one connection. On TCP and TLS bytes go straight into Paho's buffer and are looked at there.
/// Paho's WebSocket layer trusts frames as much as its MQTT layer does packets (a ping within a
/// message frees what it goes on using, of a message in several frames it loses the first ones), so
/// there each packet is put together here and handed on in frames of our making.
class InputGate {
 public:
  /// Reads at most `size` bytes: how many, 0 at the end, below 0 when there are none or it failed.
  using Source = std::function<ssize_t(void* buffer, std::size_t size)>;

  InputGate(ProtocolVersion version, Framing framing) : check_(version), framing_(framing) {}

  /// What recv() or SSL_read() is to answer Paho: like `source`, or 0 once something was refused.
  [[nodiscard]] ssize_t Read(void* buffer, std::size_t size, const Source& source);

  [[nodiscard]] PacketCheck& check() { return check_; }
  /// As PacketCheck::fault(), or what is wrong with the WebSocket's frames.
  [[nodiscard]] const std::string& fault() const {
    return fault_.empty() ? check_.fault() : fault_;
  }

 private:
  enum class State { kHttp, kFrameHeader, kControl, kData, kNoWebSocket };

  [[nodiscard]] ssize_t Refuse(std::string what);
  [[nodiscard]] ssize_t Fill(const Source& source);
  [[nodiscard]] ssize_t ReadInto(std::string& text, std::size_t count, const Source& source);
  [[nodiscard]] ssize_t Advance(const Source& source);
  [[nodiscard]] ssize_t TakeHttp(const Source& source);
  [[nodiscard]] ssize_t TakeFrameHeader(const Source& source);
  [[nodiscard]] ssize_t TakeControl(const Source& source);
  [[nodiscard]] ssize_t TakeData(const Source& source);
  [[nodiscard]] std::string_view FrameFault() const;
  [[nodiscard]] ssize_t BeginFrame();
  ssize_t EndFrame();
  void HandOnChunk();

  PacketCheck check_;
  Framing framing_;
  std::string fault_;

  State state_ = State::kHttp;
  std::string head_;    // of the HTTP answer, of the frame under way, or a whole control frame
  std::string packet_;  // under way, or whole and being handed on
  std::size_t handed_on_ = 0;
  std::uint64_t frame_left_ = 0;
  bool in_message_ = false;      // the last frame of data was not its message's last
  int frames_without_data_ = 0;  // one after the other
  std::string out_;              // what Paho gets next
  std::size_t out_at_ = 0;
};

}  // namespace fleetpub::mqtt
