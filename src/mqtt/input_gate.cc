#include "mqtt/input_gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace fleetpub::mqtt {
namespace {

// RFC 6455 §5.2.
constexpr std::uint8_t kFinal = 0x80;
constexpr std::uint8_t kReservedBits = 0x70;
constexpr std::uint8_t kMasked = 0x80;
constexpr std::uint8_t kTwoByteLength = 126;
constexpr std::uint8_t kEightByteLength = 127;
constexpr std::size_t kShortHeader = 2;
enum Opcode : std::uint8_t { kContinuation = 0, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

// Paho reads 12 bytes of the answer, then up to 1,024, and takes these for the rest of it.
constexpr std::size_t kStatusLine = 12;
constexpr std::size_t kLongestHttpHead = kStatusLine + 1024;
constexpr std::string_view kSwitching = "HTTP/1.1 101";

// In which a packet is read and handed on, so that memory grows with what has come, not with what
// is announced.
constexpr std::size_t kChunk = 64 << 10;
constexpr int kMaximumFramesWithoutData = 1'000;  // one after the other, without a pause

std::uint8_t GetByte(const std::string& text, std::size_t at) {
  return static_cast<std::uint8_t>(text[at]);
}

std::string FrameHeader(std::size_t length) {
  std::string header = {static_cast<char>(kFinal | kBinary)};
  int bytes = 8;
  if (length < kTwoByteLength) {
    return header + static_cast<char>(length);
  }
  if (length <= 0xFFFF) bytes = 2;
  header += static_cast<char>(bytes == 2 ? kTwoByteLength : kEightByteLength);
  while (bytes-- > 0) header += static_cast<char>((length >> (8 * bytes)) & 0xFF);
  return header;
}

}  // namespace

ssize_t InputGate::Read(void* buffer, std::size_t size, const Source& source) {
  if (!fault().empty()) return 0;
  if (framing_ == Framing::kNone) {
    const ssize_t got = source(buffer, size);
    if (got <= 0) return got;
    const auto* const bytes = static_cast<const std::uint8_t*>(buffer);
    return check_.Admit({bytes, static_cast<std::size_t>(got)}) ? got : 0;
  }
  if (out_at_ == out_.size()) {
    if (state_ == State::kNoWebSocket) return source(buffer, size);
    if (const ssize_t got = Fill(source); got <= 0) return got;
  }
  const std::size_t some = std::min(size, out_.size() - out_at_);
  std::copy_n(out_.data() + out_at_, some, static_cast<char*>(buffer));
  out_at_ += some;
  return static_cast<ssize_t>(some);
}

ssize_t InputGate::Refuse(std::string what) {
  fault_ = std::move(what);
  return 0;
}

// Above 0: `out_` has something for Paho.
ssize_t InputGate::Fill(const Source& source) {
  out_.clear();
  out_at_ = 0;
  if (handed_on_ > 0) HandOnChunk();
  while (out_.empty()) {
    const ssize_t got = Advance(source);
    if (got < 0) frames_without_data_ = 0;
    if (got <= 0) return got;
  }
  return 1;
}

ssize_t InputGate::Advance(const Source& source) {
  switch (state_) {
    case State::kHttp:
      return TakeHttp(source);
    case State::kFrameHeader:
      return TakeFrameHeader(source);
    case State::kControl:
      return TakeControl(source);
    default:
      return TakeData(source);
  }
}

ssize_t InputGate::ReadInto(std::string& text, std::size_t count, const Source& source) {
  const std::size_t before = text.size();
  text.resize(before + count);
  const ssize_t got = source(text.data() + before, count);
  text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return got;
}

// Byte by byte, since what stands behind the head is no longer HTTP.
ssize_t InputGate::TakeHttp(const Source& source) {
  if (const ssize_t got = ReadInto(head_, 1, source); got <= 0) return got;
  if (head_.size() == kStatusLine && head_ != kSwitching) {
    state_ = State::kNoWebSocket;  // Paho says so, and reads no further
    out_ = std::exchange(head_, {});
  } else if (head_.ends_with("\r\n\r\n")) {
    state_ = State::kFrameHeader;
    out_ = std::exchange(head_, {});
  } else if (head_.size() == kLongestHttpHead) {
    return Refuse(
        fmt::format("an answer to the WebSocket handshake of more than {} bytes", head_.size()));
  }
  return 1;
}

std::string_view InputGate::FrameFault() const {
  const std::uint8_t first = GetByte(head_, 0);
  const int opcode = first & 0xF;
  if ((first & kReservedBits) != 0) return "reserved bits are set";
  if ((GetByte(head_, 1) & kMasked) != 0) return "a server masks nothing";
  if (opcode >= kClose) {
    if (opcode > kPong) return "there is no such frame";
    const bool whole = (first & kFinal) != 0 && GetByte(head_, 1) < kTwoByteLength;
    return whole ? "" : "a control frame is short and whole";
  }
  if (opcode != kContinuation && opcode != kBinary) return "MQTT travels in binary frames";
  if ((opcode == kContinuation) != in_message_) return "a message is not continued";
  return {};
}

ssize_t InputGate::TakeFrameHeader(const Source& source) {
  std::size_t size = kShortHeader;
  if (head_.size() >= size) {
    const int length = GetByte(head_, 1);
    size += length == kTwoByteLength ? 2 : (length == kEightByteLength ? 8 : 0);
  }
  if (const ssize_t got = ReadInto(head_, size - head_.size(), source); got <= 0) return got;
  if (head_.size() < size) return 1;
  if (size == kShortHeader) {
    if (const auto wrong = FrameFault(); !wrong.empty()) {
      return Refuse(fmt::format("a malformed WebSocket frame ({})", wrong));
    }
    if (GetByte(head_, 1) >= kTwoByteLength) return 1;
    frame_left_ = GetByte(head_, 1);
  } else {
    frame_left_ = 0;
    for (std::size_t at = kShortHeader; at < size; ++at) {
      frame_left_ = frame_left_ << 8 | GetByte(head_, at);
    }
  }
  return BeginFrame();
}

ssize_t InputGate::BeginFrame() {
  if (++frames_without_data_ > kMaximumFramesWithoutData) {
    return Refuse("WebSocket frames without data, and no end of them");
  }
  const std::uint8_t first = GetByte(head_, 0);
  state_ = State::kData;
  if ((first & 0xF) >= kClose) {
    state_ = State::kControl;
  } else {
    in_message_ = (first & kFinal) == 0;
  }
  return frame_left_ == 0 ? EndFrame() : 1;
}

ssize_t InputGate::EndFrame() {
  // Paho answers a ping and a farewell.
  if (state_ == State::kControl && (GetByte(head_, 0) & 0xF) != kPong) out_ = head_;
  head_.clear();
  state_ = State::kFrameHeader;
  return 1;
}

ssize_t InputGate::TakeControl(const Source& source) {
  const ssize_t got = ReadInto(head_, frame_left_, source);
  if (got <= 0) return got;
  frame_left_ -= static_cast<std::uint64_t>(got);
  return frame_left_ == 0 ? EndFrame() : 1;
}

ssize_t InputGate::TakeData(const Source& source) {
  frames_without_data_ = 0;
  const std::size_t before = packet_.size();
  const std::size_t wanted = std::min(check_.wanted(), kChunk);
  const ssize_t got = ReadInto(packet_, std::min<std::uint64_t>(frame_left_, wanted), source);
  if (got <= 0) return got;
  frame_left_ -= static_cast<std::uint64_t>(got);
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(packet_.data()) + before;
  if (!check_.Admit({bytes, static_cast<std::size_t>(got)})) return 0;
  if (check_.IsBetweenPackets()) HandOnChunk();
  return frame_left_ == 0 ? EndFrame() : 1;
}

void InputGate::HandOnChunk() {
  const std::size_t some = std::min(kChunk, packet_.size() - handed_on_);
  out_ = FrameHeader(some);
  out_.append(packet_, handed_on_, some);
  handed_on_ += some;
  if (handed_on_ < packet_.size()) return;
  handed_on_ = 0;
  packet_.clear();
  if (packet_.capacity() > kChunk) packet_.shrink_to_fit();
}

}  // namespace fleetpub::mqtt
