// What a broker sends, looked at before Paho decodes it: Paho believes the lengths inside a packet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_set>

#include "mqtt/transport.h"

namespace fleetpub::mqtt {

/// The largest packet that we take, in bytes behind its fixed header: a message of the 16 MiB that
/// our reader of JSON takes, its topic, and something beyond, so that the reader can say what is
/// too long.
inline constexpr std::uint32_t kMaximumIncomingPacket = 17U << 20;
/// The most that MQTT 5's properties of one packet may take: the longest pair of texts fits. Paho
/// keeps each property apart, which costs up to a hundred times its bytes.
inline constexpr std::uint32_t kMaximumIncomingProperties = 132U << 10;
/// What may wait for its reader on one connection, in bytes of memory.
inline constexpr std::size_t kMaximumWaiting = std::size_t{40} << 20;

/// Why a packet of MQTT 5 refuses or ends something (§2.4, §4.13). Texts of the broker, untrusted.
struct Reason {
  std::uint32_t code = 0;
  std::string text;    ///< the reason string, its first 256 bytes; "": none
  std::string server;  ///< the server reference, likewise
};

/// The packets that a server sends on one connection (MQTT 3.1.1 and 5, §2 and §3), in pieces as
/// they come. Reads each byte once and keeps none but those of a reason. Knows the turns too:
/// CONNACK first and once, a SUBACK for each SUBSCRIBE, nothing after DISCONNECT.
class PacketCheck {
 public:
  explicit PacketCheck(ProtocolVersion version) : v5_(version == ProtocolVersion::k5) {}

  /// Takes the next bytes in. False, from then on: they hold what nobody may be given. A packet is
  /// only ever refused before its last byte was taken in.
  [[nodiscard]] bool Admit(std::span<const std::uint8_t> bytes);

  /// What the broker did, after "the broker sent ": "a PUBLISH packet whose properties are cut
  /// off". Empty as long as all is well.
  [[nodiscard]] const std::string& fault() const { return fault_; }

  /// Of the packet that came last; the code of DISCONNECT only.
  [[nodiscard]] const Reason& reason() const { return reason_; }
  [[nodiscard]] bool HasDisconnected() const { return disconnected_; }
  /// The fault is a first answer that goes on with an authentication (MQTT 5 §3.15).
  [[nodiscard]] bool WantsMoreAuthentication() const { return wants_more_; }

  /// How many bytes may be read without touching the packet behind this one; at least 1.
  [[nodiscard]] std::size_t wanted() const;
  [[nodiscard]] bool IsBetweenPackets() const { return field_ == Field::kType; }

  /// The one SUBACK or UNSUBACK that may come for these filters.
  void ExpectSuback(std::size_t filters) { subacks_ = filters; }
  void ExpectUnsuback(std::size_t filters) { unsubacks_ = filters; }

  /// What a message costs between its admission and its reader. Together no more than
  /// kMaximumWaiting.
  [[nodiscard]] static std::size_t EstimateCost(std::size_t topic, std::size_t payload) {
    return kCostOfAMessage + topic + payload;
  }
  [[nodiscard]] static std::size_t CostOfProperties(std::size_t size) {
    return size * kCostOfAPropertyByte;
  }
  [[nodiscard]] std::size_t waiting() const { return waiting_; }
  void Release(std::size_t cost) { waiting_ -= cost < waiting_ ? cost : waiting_; }

 private:
  enum class Field : std::uint8_t {
    kType,
    kLength,
    kConnackFlags,
    kConnackCode,
    kTopicLength,
    kTopic,
    kPacketId,
    kReason,
    kPropertiesLength,
    kPropertyId,
    kPropertyNumber,
    kPropertyVarint,
    kPropertyTextLength,
    kPropertyText,
    kCode,
    kRest,
  };

  // Measured with Debian's Paho, which keeps a record of some 200 bytes of each block of memory.
  static constexpr std::size_t kCostOfAMessage = 1100;
  static constexpr std::size_t kCostOfAPropertyByte = 100;

  [[nodiscard]] bool IsVarint() const;
  [[nodiscard]] std::size_t room() const { return in_properties_ ? properties_left_ : left_; }
  void Refuse(std::string_view what);
  void RefuseWhole(std::string what);
  void Spend(std::size_t count);
  void KeepReason(std::span<const std::uint8_t> bytes);
  void Begin(Field field, std::size_t width = 1);
  void Skip(Field field, std::size_t count);
  void End();

  void TakeType(std::uint8_t byte);
  void Take(std::uint8_t byte);
  void Finish();
  void FinishVariableHeader();
  void FinishProperty();
  void BeginBody();
  void BeginProperties();
  void NextProperty();
  void AfterTopic();
  void AfterPacketId();
  void AfterProperties();
  void BeginCodes();
  void BeginPayload();

  bool v5_;
  bool connected_ = false;     // CONNACK has come
  bool disconnected_ = false;  // DISCONNECT has come
  bool wants_more_ = false;    // AUTH has come instead of CONNACK
  std::size_t subacks_ = 0;    // filters of the SUBSCRIBE under way
  std::size_t unsubacks_ = 0;
  std::unordered_set<std::uint32_t> qos2_ids_;  // until their PUBREL
  std::size_t waiting_ = 0;
  std::string fault_;
  Reason reason_;

  // The packet under way.
  std::uint8_t type_ = 0;
  std::uint8_t flags_ = 0;
  std::size_t left_ = 0;  // bytes of it that are still to come
  std::uint32_t topic_length_ = 0;
  std::uint32_t packet_id_ = 0;
  std::uint32_t properties_length_ = 0;
  std::size_t properties_left_ = 0;
  bool in_properties_ = false;

  // The field under way.
  Field field_ = Field::kType;
  std::uint32_t property_ = 0;    // its identifier
  bool is_first_of_two_ = false;  // texts of a pair
  std::uint8_t digits_ = 0;       // of a variable byte integer
  std::size_t width_ = 0;         // bytes that a number still lacks
  std::size_t skip_ = 0;          // bytes that nobody looks at
  std::uint32_t number_ = 0;
};

}  // namespace fleetpub::mqtt
