#include "support/publish_packet.h"

namespace fleetpub::testing {

std::string PublishPacket(std::string_view topic, std::string_view payload,
                          std::string_view properties) {
  std::string packet = "\x30";
  std::size_t length = 2 + topic.size() + properties.size() + payload.size();
  for (; length >= 0x80; length >>= 7U) packet += static_cast<char>(0x80 | (length & 0x7F));
  packet += {static_cast<char>(length), static_cast<char>(topic.size() >> 8U),
             static_cast<char>(topic.size() & 0xFF)};
  return packet.append(topic).append(properties).append(payload);
}

}  // namespace fleetpub::testing
