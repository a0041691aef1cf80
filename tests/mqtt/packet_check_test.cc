// Packets of brokers, sound and otherwise (MQTT 3.1.1 and 5, §2 and §3).
#include "mqtt/packet_check.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "support/publish_packet.h"

namespace fleetpub::mqtt {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto k311 = ProtocolVersion::k311;
constexpr auto k5 = ProtocolVersion::k5;

/// "30 04" → its bytes.
std::string Bytes(std::string_view hex) {
  std::string bytes;
  for (std::size_t at = 0; at < hex.size(); at += 3) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(at, 2)), nullptr, 16));
  }
  return bytes;
}

bool Admit(PacketCheck& check, std::string_view bytes) {
  return check.Admit({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

PacketCheck Connected(ProtocolVersion version) {
  PacketCheck check(version);
  EXPECT_TRUE(Admit(check, Bytes(version == k5 ? "20 03 00 00 00" : "20 02 00 00")));
  return check;
}

std::string Publish(std::size_t payload, std::string_view properties = "") {
  return testing::PublishPacket("a", std::string(payload, 'x'), properties);
}

struct Case {
  ProtocolVersion version;
  const char* hex;
};

const Case kSound[] = {
    {k311, "30 03 00 01 61"},                     // nothing in it
    {k311, "32 06 00 01 61 00 07 78"},            // QoS 1
    {k311, "3D 06 00 01 61 00 07 78"},            // QoS 2, retained, again
    {k311, "30 83 00 00 01 61"},                  // a length longer than need be
    {k311, "40 02 00 01"},                        // PUBACK
    {k311, "50 02 00 01"},                        // PUBREC
    {k311, "62 02 00 01"},                        // PUBREL
    {k311, "70 02 00 01"},                        // PUBCOMP
    {k311, "D0 00"},                              // PINGRESP
    {k5, "30 05 00 01 61 00 78"},                 // no properties
    {k5, "30 06 00 01 61 02 01 01"},              // a byte
    {k5, "30 07 00 01 61 03 23 00 05"},           // two bytes
    {k5, "30 09 00 01 61 05 02 00 00 00 05"},     // four bytes
    {k5, "30 0A 00 01 61 05 0B FF FF FF 7F 78"},  // a variable byte integer
    {k5, "30 09 00 01 61 05 03 00 02 61 62"},     // a text
    {k5, "30 07 00 01 61 03 09 00 00"},           // binary data, none of it
    {k5, "30 09 00 01 61 05 26 00 00 00 00"},     // a pair of nothing
    {k5, "30 0D 00 01 61 08 26 00 01 61 00 02 62 63 78"},
    {k5, "30 09 00 01 61 04 01 00 01 01 78"},  // twice: tolerated
    {k5, "40 02 00 01"},
    {k5, "40 03 00 01 87"},                 // with a reason
    {k5, "40 04 00 01 00 00"},              // and no properties
    {k5, "40 08 00 01 87 04 1F 00 01 78"},  // and why
    {k5, "E0 00"},                          // DISCONNECT
    {k5, "E0 01 8B"},
    {k5, "E0 02 8B 00"},
};

TEST(PacketCheck, AdmitsWhatIsWellFramed) {
  for (const auto& [version, hex] : kSound) {
    PacketCheck check = Connected(version);
    EXPECT_TRUE(Admit(check, Bytes(hex))) << hex << ": " << check.fault();
    EXPECT_TRUE(check.IsBetweenPackets()) << hex;
  }
}

const Case kMalformed[] = {
    {k5, "30 04 00 01 61 80"},                 // its property length is cut off
    {k5, "32 06 00 01 61 00 01 80"},           // at QoS 1 too
    {k5, "30 03 00 01 61"},                    // has none
    {k5, "30 04 00 01 61 01"},                 // properties behind its end
    {k5, "30 09 00 01 61 FF FF FF FF 01 78"},  // a property length of five bytes
    {k5, "30 05 00 01 61 01 01"},              // a property without its byte
    {k5, "30 07 00 01 61 02 02 00 00"},        // four bytes of which two are there
    {k5, "30 08 00 01 61 04 03 00 02 61"},     // a text longer than the properties
    {k5, "30 09 00 01 61 04 03 00 02 61 62"},  // and than the packet
    {k5, "30 09 00 01 61 05 26 00 00 00 01"},  // the second of a pair
    {k5, "30 07 00 01 61 03 26 00 00"},        // a pair of one
    {k5, "30 06 00 01 61 02 0B 80"},           // an integer without an end
    {k5, "30 09 00 01 61 05 0B 80 80 80 80"},  // of five bytes
    {k5, "30 06 00 01 61 02 7F 00"},           // no such property
    {k5, "30 06 00 01 61 02 00 00"},
    {k311, "30 00"},           // no topic
    {k311, "30 02 00 00"},     // an empty one
    {k311, "30 01 00"},        // half a length
    {k311, "30 03 00 02 61"},  // a topic longer than the packet
    {k311, "30 03 FF FF 61"},
    {k311, "32 04 00 01 61 00"},     // half an id
    {k311, "32 05 00 01 61 00 00"},  // id 0
    {k311, "36 05 00 01 61 00 01"},  // QoS 3
    {k311, "30 FF FF FF FF 01"},     // a length of five bytes
    {k311, "40 00"},
    {k311, "40 01 00"},
    {k311, "40 02 00 00"},
    {k311, "40 03 00 01 00"},  // what 3.1.1 does not have
    {k311, "41 02 00 01"},     // flags
    {k311, "60 02 00 01"},
    {k311, "D0 01 00"},
    {k311, "D1 00"},
    {k5, "40 04 00 01 00 01"},     // properties cut off
    {k5, "40 05 00 01 00 00 00"},  // something behind them
    {k5, "E0 02 8B 80"},
    {k5, "E0 03 8B 00 00"},
};

TEST(PacketCheck, RefusesWhatIsNot) {
  for (const auto& [version, hex] : kMalformed) {
    PacketCheck check = Connected(version);
    EXPECT_FALSE(Admit(check, Bytes(hex))) << hex;
    EXPECT_THAT(check.fault(), HasSubstr("malformed packet")) << hex;
    EXPECT_FALSE(Admit(check, Bytes("D0 00"))) << "for good";
  }
}

// Paho decodes a packet when it has its last byte: that one must not be admitted.
TEST(PacketCheck, RefusesByteByByteNoLaterThanWithTheLastOne) {
  for (const auto& [version, hex] : kMalformed) {
    PacketCheck check = Connected(version);
    bool admitted = true;
    for (const char byte : Bytes(hex)) admitted = admitted && Admit(check, {&byte, 1});
    EXPECT_FALSE(admitted) << hex;
  }
  for (const auto& [version, hex] : kSound) {
    PacketCheck check = Connected(version);
    for (const char byte : Bytes(hex)) {
      EXPECT_TRUE(Admit(check, {&byte, 1})) << hex << ": " << check.fault();
    }
  }
}

TEST(PacketCheck, RefusesWhatNoServerSends) {
  for (const char* hex : {"00 00", "10 00", "82 02 00 01", "A2 02 00 01", "C0 00", "F0 00",
                          "F0 02 18 00", "53 53 48 2D"}) {
    for (const auto version : {k311, k5}) {
      PacketCheck check = Connected(version);
      EXPECT_FALSE(Admit(check, Bytes(hex))) << hex;
    }
  }
  PacketCheck old = Connected(k311);
  EXPECT_FALSE(Admit(old, Bytes("E0 00"))) << "DISCONNECT came with MQTT 5";
}

TEST(PacketCheck, ReadsAConnackOfEitherVersion) {
  for (const char* hex : {"20 02 00 00", "20 02 00 05", "20 02 01 00", "20 03 00 84 00"}) {
    PacketCheck check(k311);
    EXPECT_TRUE(Admit(check, Bytes(hex))) << hex << check.fault();
  }
  for (const char* hex : {"20 03 00 00 00", "20 03 00 84 00", "20 06 00 00 03 21 00 0A",
                          "20 08 00 00 05 27 00 01 00 00"}) {
    PacketCheck check(k5);
    EXPECT_TRUE(Admit(check, Bytes(hex))) << hex << check.fault();
  }
  for (const char* hex : {"20 00", "20 01 00", "20 02 02 00", "20 03 00 00 00", "21 02 00 00"}) {
    PacketCheck check(k311);
    EXPECT_FALSE(Admit(check, Bytes(hex))) << hex;
  }
  for (const char* hex :
       {"20 02 00 00", "20 02 00 01", "20 03 00 00 01", "20 03 00 00 80", "20 06 00 00 04 21 00 0A",
        "20 07 00 00 03 21 00 0A 00", "20 06 00 00 03 27 00 0A"}) {
    PacketCheck check(k5);
    EXPECT_FALSE(Admit(check, Bytes(hex))) << hex;
  }
}

TEST(PacketCheck, KnowsAnAuthenticationThatGoesOn) {
  PacketCheck check(k5);
  EXPECT_FALSE(Admit(check, Bytes("F0")));
  EXPECT_TRUE(check.WantsMoreAuthentication());
  PacketCheck later = Connected(k5);
  EXPECT_FALSE(Admit(later, Bytes("F0 02 18 00")));
  EXPECT_FALSE(later.WantsMoreAuthentication()) << "only a client may authenticate again";
  for (const char* hex : {"F1", "20 03 00 8C 00"}) {
    PacketCheck other(k5);
    EXPECT_EQ(Admit(other, Bytes(hex)), hex[0] == '2');
    EXPECT_FALSE(other.WantsMoreAuthentication()) << hex;
  }
  PacketCheck old(k311);
  EXPECT_FALSE(Admit(old, Bytes("F0 02 18 00")));
  EXPECT_FALSE(old.WantsMoreAuthentication()) << "AUTH came with MQTT 5";
}

TEST(PacketCheck, KeepsTheReasonOfADisconnect) {
  PacketCheck check(ProtocolVersion::k5);
  const std::string packets =
      std::string("\x20\3\0\0\0", 5) + std::string("\xe0\x0a\x97\x08\x1f\0\5quota", 12);
  for (const char byte : packets) {
    const auto one = static_cast<std::uint8_t>(byte);
    ASSERT_TRUE(check.Admit({&one, 1})) << check.fault();
  }
  EXPECT_TRUE(check.HasDisconnected());
  EXPECT_EQ(check.reason().code, 0x97);
  EXPECT_EQ(check.reason().text, "quota");
}

TEST(PacketCheck, KnowsWhoseTurnItIs) {
  PacketCheck early(k311);
  EXPECT_FALSE(Admit(early, Bytes("30 03 00 01 61")));
  EXPECT_THAT(early.fault(), HasSubstr("before its CONNACK"));
  PacketCheck twice = Connected(k311);
  EXPECT_FALSE(Admit(twice, Bytes("20 02 00 00")));
  EXPECT_THAT(twice.fault(), HasSubstr("second CONNACK"));
  PacketCheck late = Connected(k5);
  EXPECT_FALSE(Admit(late, Bytes("E0 00 D0 00")));
  EXPECT_THAT(late.fault(), HasSubstr("after its DISCONNECT"));
}

TEST(PacketCheck, TakesOneSubackForASubscription) {
  const std::pair<ProtocolVersion, std::string> subacks[] = {
      {k311, Bytes("90 05 00 01 00 02 80")}, {k5, Bytes("90 06 00 01 00 00 02 87")}};
  for (const auto& [version, suback] : subacks) {
    PacketCheck check = Connected(version);
    PacketCheck unasked = check;
    EXPECT_FALSE(Admit(unasked, suback));
    EXPECT_THAT(unasked.fault(), HasSubstr("nobody asked for"));
    for (const std::size_t filters : {1U, 2U, 4U, 100U}) {
      PacketCheck other = check;
      other.ExpectSuback(filters);
      EXPECT_FALSE(Admit(other, suback)) << filters;
    }
    check.ExpectSuback(3);
    EXPECT_TRUE(Admit(check, suback)) << check.fault();
    EXPECT_FALSE(Admit(check, suback)) << "no second one";
  }
  PacketCheck strange = Connected(k311);
  strange.ExpectSuback(1);
  EXPECT_FALSE(Admit(strange, Bytes("90 03 00 01 03"))) << "QoS 3";
}

TEST(PacketCheck, TakesOneUnsubackForAnUnsubscription) {
  const std::pair<ProtocolVersion, std::string> unsubacks[] = {{k311, Bytes("B0 02 00 01")},
                                                               {k5, Bytes("B0 05 00 01 00 00 11")}};
  for (const auto& [version, unsuback] : unsubacks) {
    PacketCheck check = Connected(version);
    PacketCheck unasked = check;
    EXPECT_FALSE(Admit(unasked, unsuback));
    check.ExpectUnsuback(2);
    EXPECT_TRUE(Admit(check, unsuback)) << check.fault();
    EXPECT_FALSE(Admit(check, unsuback));
  }
}

TEST(PacketCheck, RefusesAQos2MessageUnderAnIdThatIsInUse) {
  for (const auto version : {k311, k5}) {
    const std::string message =
        Bytes(version == k5 ? "34 06 00 01 61 00 07 00" : "34 05 00 01 61 00 07");
    PacketCheck check = Connected(version);
    EXPECT_TRUE(Admit(check, message + Bytes("62 02 00 07") + message)) << check.fault();
    EXPECT_FALSE(Admit(check, message));
    EXPECT_THAT(check.fault(), HasSubstr("in use"));
  }
}

TEST(PacketCheck, RefusesWhatIsTooLarge) {
  PacketCheck packet = Connected(k311);
  EXPECT_TRUE(Admit(packet, Bytes("30 80 80 C0 08 00 01 61"))) << packet.fault();
  PacketCheck larger = Connected(k311);
  EXPECT_FALSE(Admit(larger, Bytes("30 81 80 C0 08")));
  EXPECT_THAT(larger.fault(), HasSubstr("17825793 bytes"));
  PacketCheck properties = Connected(k5);
  EXPECT_FALSE(Admit(properties, Bytes("30 8A 80 20 00 01 61 81 80 10")));
  EXPECT_THAT(properties.fault(), HasSubstr("properties"));
}

TEST(PacketCheck, BoundsWhatWaitsForItsReader) {
  for (const std::size_t payload : {std::size_t{0}, std::size_t{2'000}, std::size_t{1'000'000}}) {
    PacketCheck check = Connected(k311);
    const std::string message = Publish(payload);
    std::size_t count = 0;
    for (; Admit(check, message); ++count) ASSERT_LT(count * payload, kMaximumWaiting);
    EXPECT_THAT(check.fault(), HasSubstr("wait to be read"));
    EXPECT_LE(count, kMaximumWaiting / PacketCheck::EstimateCost(1, payload));
    PacketCheck read = Connected(k311);
    for (std::size_t i = 0; i < count + 10; ++i) {
      ASSERT_TRUE(Admit(read, message)) << read.fault();
      read.Release(PacketCheck::EstimateCost(1, payload));
    }
    EXPECT_EQ(read.waiting(), 0U);
  }
}

TEST(PacketCheck, CountsWhatPropertiesCost) {
  PacketCheck check = Connected(k5);
  ASSERT_TRUE(Admit(check, Publish(7, Bytes("05 26 00 00 00 00")))) << check.fault();
  check.Release(PacketCheck::CostOfProperties(5));
  EXPECT_EQ(check.waiting(), PacketCheck::EstimateCost(1, 7));
}

TEST(PacketCheck, KnowsHowMuchBelongsToThePacket) {
  PacketCheck check = Connected(k311);
  const std::string packet = Publish(200);
  std::vector<std::size_t> wanted;
  for (const char byte : packet) {
    wanted.push_back(check.wanted());
    ASSERT_TRUE(Admit(check, {&byte, 1}));
  }
  EXPECT_EQ(std::vector(wanted.begin(), wanted.begin() + 4),
            (std::vector<std::size_t>{2, 1, 1, packet.size() - 3}));
  EXPECT_EQ(wanted.back(), 1U);
  EXPECT_EQ(check.wanted(), 2U);
}

}  // namespace
}  // namespace fleetpub::mqtt
