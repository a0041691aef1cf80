#include "mqtt/packet_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace fleetpub::mqtt {
namespace {

// Identifiers of properties (§2.2.2.2).
constexpr std::uint32_t kServerReference = 0x1C;
constexpr std::uint32_t kReasonString = 0x1F;
constexpr std::size_t kLongestReason = 256;

// MQTT 5 §2.1.2.
enum Type : std::uint8_t {
  kConnack = 2,
  kPublish = 3,
  kPuback = 4,
  kPubrec = 5,
  kPubrel = 6,
  kPubcomp = 7,
  kSuback = 9,
  kUnsuback = 11,
  kPingresp = 13,
  kDisconnect = 14,
  kAuth = 15,
};

struct TypeRule {
  std::string_view name;  // empty: a server never sends it to us
  int flags = 0;          // -1: it has its own meanings
};

constexpr std::array<TypeRule, 16> kTypes{{
    {""},             // reserved
    {""},             // CONNECT
    {"CONNACK"},      //
    {"PUBLISH", -1},  //
    {"PUBACK"},       //
    {"PUBREC"},       //
    {"PUBREL", 2},    // §3.6.1
    {"PUBCOMP"},      //
    {""},             // SUBSCRIBE
    {"SUBACK"},       //
    {""},             // UNSUBSCRIBE
    {"UNSUBACK"},     //
    {""},             // PINGREQ
    {"PINGRESP"},     //
    {"DISCONNECT"},   // MQTT 5 only
    {""},             // AUTH, which asks for a step that we do not have; Paho reads it wrongly
}};

constexpr int kQosBits = 6;
constexpr int kExactlyOnceBits = 4;
constexpr int kMaximumDigits = 4;  // of a variable byte integer, §1.5.5
constexpr std::uint32_t kRefusal = 0x80;

// MQTT 5 §2.2.2.2: what follows a property's identifier.
enum class Kind { kByte = 1, kTwoBytes = 2, kFourBytes = 4, kVarint, kText, kPair };

std::optional<Kind> FindKind(std::uint32_t property) {
  switch (property) {
    case 0x01:  // payload format indicator
    case 0x17:  // request problem information
    case 0x19:  // request response information
    case 0x24:  // maximum QoS
    case 0x25:  // retain available
    case 0x28:  // wildcard subscription available
    case 0x29:  // subscription identifiers available
    case 0x2A:  // shared subscription available
      return Kind::kByte;
    case 0x13:  // server keep alive
    case 0x21:  // receive maximum
    case 0x22:  // topic alias maximum
    case 0x23:  // topic alias
      return Kind::kTwoBytes;
    case 0x02:  // message expiry interval
    case 0x11:  // session expiry interval
    case 0x18:  // will delay interval
    case 0x27:  // maximum packet size
      return Kind::kFourBytes;
    case 0x0B:  // subscription identifier
      return Kind::kVarint;
    case 0x03:  // content type
    case 0x08:  // response topic
    case 0x09:  // correlation data
    case 0x12:  // assigned client identifier
    case 0x15:  // authentication method
    case 0x16:  // authentication data
    case 0x1A:  // response information
    case kServerReference:
    case kReasonString:
      return Kind::kText;
    case 0x26:  // user property
      return Kind::kPair;
    default:
      return std::nullopt;
  }
}

}  // namespace

bool PacketCheck::Admit(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty() && fault_.empty()) {
    if (skip_ == 0) {
      Take(bytes.front());
      bytes = bytes.subspan(1);
      continue;
    }
    const std::size_t some = std::min(skip_, bytes.size());
    if (field_ == Field::kPropertyText) KeepReason(bytes.first(some));
    bytes = bytes.subspan(some);
    skip_ -= some;
    Spend(some);
    if (skip_ == 0) Finish();
  }
  return fault_.empty();
}

std::size_t PacketCheck::wanted() const {
  if (field_ == Field::kType) return 2;  // no packet is shorter
  return field_ == Field::kLength ? 1 : std::max<std::size_t>(left_, 1);
}

bool PacketCheck::IsVarint() const {
  return field_ == Field::kLength || field_ == Field::kPropertiesLength ||
         field_ == Field::kPropertyVarint;
}

void PacketCheck::RefuseWhole(std::string what) { fault_ = std::move(what); }

void PacketCheck::Refuse(std::string_view what) {
  RefuseWhole(fmt::format("a malformed packet ({}: {})", kTypes[type_].name, what));
}

void PacketCheck::Spend(std::size_t count) {
  left_ -= count;
  if (in_properties_) properties_left_ -= count;
}

void PacketCheck::KeepReason(std::span<const std::uint8_t> bytes) {
  if (property_ != kReasonString && property_ != kServerReference) return;
  std::string& text = property_ == kReasonString ? reason_.text : reason_.server;
  const std::size_t more = std::min(bytes.size(), kLongestReason - text.size());
  text.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(more));
}

void PacketCheck::Begin(Field field, std::size_t width) {
  if (width > room()) {
    return Refuse(in_properties_ ? "a property is cut off" : "it is cut off");
  }
  field_ = field;
  width_ = width;
  number_ = 0;
  digits_ = 0;
}

void PacketCheck::Skip(Field field, std::size_t count) {
  if (count > room()) {
    return Refuse(in_properties_ ? "a property is cut off" : "its topic is cut off");
  }
  field_ = field;
  skip_ = count;
  if (count == 0) Finish();
}

void PacketCheck::End() {
  if (left_ > 0) return Refuse("it is too long");
  field_ = Field::kType;
}

void PacketCheck::TakeType(std::uint8_t byte) {
  type_ = byte >> 4;
  reason_ = {};
  flags_ = byte & 0xF;
  const TypeRule& rule = kTypes[type_];
  if (byte == kAuth << 4 && v5_ && !connected_) {
    wants_more_ = true;
    return RefuseWhole("an AUTH packet before its CONNACK");
  }
  if (rule.name.empty() || (type_ == kDisconnect && !v5_)) {
    return RefuseWhole(
        fmt::format("what is no packet for a client (it begins with 0x{:02X})", byte));
  }
  if (rule.flags >= 0 ? flags_ != rule.flags : (flags_ & kQosBits) == kQosBits) {
    return Refuse("its flags are wrong");
  }
  if (disconnected_) {
    return RefuseWhole(fmt::format("a {} packet after its DISCONNECT", rule.name));
  }
  if ((type_ == kConnack) == connected_) {
    return RefuseWhole(connected_ ? "a second CONNACK packet"
                                  : fmt::format("a {} packet before its CONNACK", rule.name));
  }
  field_ = Field::kLength;
  number_ = 0;
  digits_ = 0;
}

void PacketCheck::Take(std::uint8_t byte) {
  if (field_ == Field::kType) return TakeType(byte);
  if (field_ != Field::kLength) Spend(1);
  if (!IsVarint()) {
    number_ = (number_ << 8) | byte;
    if (--width_ == 0) Finish();
    return;
  }
  number_ |= static_cast<std::uint32_t>(byte & 0x7FU) << (7 * digits_);
  ++digits_;
  if (byte < 0x80) return Finish();
  if (digits_ == kMaximumDigits) return Refuse("a length has more than four bytes");
  if (field_ != Field::kLength && room() == 0) return Refuse("a length is cut off");
}

// The field is complete: what comes next?
void PacketCheck::Finish() {
  switch (field_) {
    case Field::kLength:
      left_ = number_;
      if (left_ > kMaximumIncomingPacket) {
        return RefuseWhole(fmt::format("a {} packet of {} bytes, more than the limit of {}",
                                       kTypes[type_].name, left_, kMaximumIncomingPacket));
      }
      return BeginBody();
    case Field::kPropertyId:
    case Field::kPropertyNumber:
    case Field::kPropertyVarint:
    case Field::kPropertyTextLength:
    case Field::kPropertyText:
      return FinishProperty();
    default:
      return FinishVariableHeader();
  }
}

void PacketCheck::BeginBody() {
  in_properties_ = false;
  properties_length_ = 0;
  switch (type_) {
    case kConnack:
      return Begin(Field::kConnackFlags);
    case kPublish:
      return Begin(Field::kTopicLength, 2);
    case kPingresp:
      return End();
    case kDisconnect:
      disconnected_ = true;
      return left_ == 0 ? End() : Begin(Field::kReason);
    default:
      return Begin(Field::kPacketId, 2);
  }
}

void PacketCheck::FinishVariableHeader() {
  switch (field_) {
    case Field::kConnackFlags:
      return number_ > 1 ? Refuse("its flags are wrong") : Begin(Field::kConnackCode);
    case Field::kConnackCode:
      connected_ = true;
      // A broker of the other version refuses in that version's form. On MQTT 5 Paho frees
      // properties that it never read when there are none.
      if (v5_ && left_ == 0) return RefuseWhole("a CONNACK packet of MQTT 3.1.1");
      if (v5_) return Begin(Field::kPropertiesLength);
      return number_ == 0 || left_ == 0 ? End() : Skip(Field::kRest, left_);
    case Field::kTopicLength:
      topic_length_ = number_;
      return number_ == 0 ? Refuse("it has no topic") : Skip(Field::kTopic, number_);
    case Field::kTopic:
      return AfterTopic();
    case Field::kPacketId:
      packet_id_ = number_;
      return number_ == 0 ? Refuse("its packet identifier is 0") : AfterPacketId();
    case Field::kReason:
      reason_.code = number_;
      return left_ == 0 ? End() : Begin(Field::kPropertiesLength);
    case Field::kPropertiesLength:
      return BeginProperties();
    case Field::kCode:
      if (type_ == kSuback && number_ > 2 && number_ < kRefusal) {
        return Refuse("it grants what does not exist");
      }
      return left_ == 0 ? End() : Begin(Field::kCode);
    default:
      return End();
  }
}

void PacketCheck::AfterTopic() {
  if ((flags_ & kQosBits) != 0) return Begin(Field::kPacketId, 2);
  packet_id_ = 0;
  return v5_ ? Begin(Field::kPropertiesLength) : BeginPayload();
}

void PacketCheck::AfterPacketId() {
  switch (type_) {
    case kPublish:
      return v5_ ? Begin(Field::kPropertiesLength) : BeginPayload();
    case kSuback:
      return v5_ ? Begin(Field::kPropertiesLength) : BeginCodes();
    case kUnsuback:
      if (unsubacks_ == 0) return RefuseWhole("an UNSUBACK packet that nobody asked for");
      if (v5_) return Begin(Field::kPropertiesLength);
      unsubacks_ = 0;
      return End();
    default:
      if (type_ == kPubrel) qos2_ids_.erase(packet_id_);
      return left_ == 0 || !v5_ ? End() : Begin(Field::kReason);
  }
}

void PacketCheck::BeginProperties() {
  properties_length_ = number_;
  if (number_ > left_) return Refuse("its properties are cut off");
  if (number_ > kMaximumIncomingProperties) {
    return RefuseWhole(
        fmt::format("a {} packet with {} bytes of properties, more than the {} that "
                    "are taken here",
                    kTypes[type_].name, number_, kMaximumIncomingProperties));
  }
  in_properties_ = true;
  properties_left_ = number_;
  NextProperty();
}

void PacketCheck::NextProperty() {
  if (properties_left_ > 0) return Begin(Field::kPropertyId);
  in_properties_ = false;
  AfterProperties();
}

void PacketCheck::FinishProperty() {
  if (field_ == Field::kPropertyTextLength) return Skip(Field::kPropertyText, number_);
  if (field_ == Field::kPropertyText && std::exchange(is_first_of_two_, false)) {
    return Begin(Field::kPropertyTextLength, 2);
  }
  if (field_ != Field::kPropertyId) return NextProperty();
  property_ = number_;
  const auto kind = FindKind(number_);
  if (!kind) return Refuse(fmt::format("there is no property 0x{:02X}", number_));
  is_first_of_two_ = kind == Kind::kPair;
  switch (*kind) {
    case Kind::kVarint:
      return Begin(Field::kPropertyVarint);
    case Kind::kText:
    case Kind::kPair:
      return Begin(Field::kPropertyTextLength, 2);
    default:
      return Begin(Field::kPropertyNumber, static_cast<std::size_t>(*kind));
  }
}

void PacketCheck::AfterProperties() {
  switch (type_) {
    case kPublish:
      return BeginPayload();
    case kSuback:
    case kUnsuback:
      return BeginCodes();
    default:
      return End();
  }
}

void PacketCheck::BeginCodes() {
  std::size_t& expected = type_ == kSuback ? subacks_ : unsubacks_;
  if (expected == 0) {
    return RefuseWhole(fmt::format("a {} packet that nobody asked for", kTypes[type_].name));
  }
  if (std::exchange(expected, 0) != left_) {
    return Refuse("it has not one code for each topic filter");
  }
  Begin(Field::kCode);
}

void PacketCheck::BeginPayload() {
  // Paho drops one of the two, so that nobody would ever release it.
  if ((flags_ & kQosBits) == kExactlyOnceBits && !qos2_ids_.insert(packet_id_).second) {
    return RefuseWhole("a second message under a packet identifier that is in use");
  }
  waiting_ += EstimateCost(topic_length_, left_) + CostOfProperties(properties_length_);
  if (waiting_ > kMaximumWaiting) {
    return RefuseWhole(fmt::format("more than can be taken in: {} MiB of messages wait to be read",
                                   kMaximumWaiting >> 20));
  }
  Skip(Field::kRest, left_);
}

}  // namespace fleetpub::mqtt
