// What a broker sends: the check in front of Paho, and Paho behind it.
//
// The first byte says how to go about it (kFlags), the rest is the broker's.
#include <MQTTClient.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "fuzz/fuzz.h"
#include "mqtt/input_gate.h"
#include "mqtt/paho/paho_session.h"
#include "mqtt/paho/paho_sockets.h"

using namespace fleetpub;
using mqtt::InputGate;
using mqtt::PacketCheck;
using mqtt::ProtocolVersion;

namespace {

enum Flags : unsigned {
  kV5 = 1,
  kOwnConnack = 2,    // the broker's bytes begin with its CONNACK
  kSubscribes = 4,    // we are waiting for a SUBACK
  kUnsubscribes = 8,  // for an UNSUBACK
  kPublishes = 16,    // have published at QoS 1 or 2
  kWebSocket = 32,    // the bytes are frames
};

constexpr std::size_t kFilters = 2;

std::string_view Connack(bool v5) {
  return v5 ? std::string_view("\x20\x03\0\0\0", 5) : std::string_view("\x20\x02\0\0", 4);
}

bool Admit(PacketCheck& check, std::string_view bytes) {
  return check.Admit({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

PacketCheck MakeCheck(unsigned flags) {
  PacketCheck check((flags & kV5) != 0 ? ProtocolVersion::k5 : ProtocolVersion::k311);
  if ((flags & kSubscribes) != 0) check.ExpectSuback(kFilters);
  if ((flags & kUnsubscribes) != 0) check.ExpectUnsuback(kFilters);
  return check;
}

// Whole or byte by byte: the status is the same. How many packets were admitted.
int CheckAlone(unsigned flags, std::string_view bytes) {
  PacketCheck whole = MakeCheck(flags);
  const bool admitted = Admit(whole, bytes);
  PacketCheck pieces = MakeCheck(flags);
  int packets = 0;
  for (std::size_t at = 0; at < bytes.size() && Admit(pieces, bytes.substr(at, 1)); ++at) {
    fuzz::Require(pieces.wanted() > 0);
    packets += pieces.IsBetweenPackets() ? 1 : 0;
  }
  fuzz::Require(admitted == whole.fault().empty() && whole.fault() == pieces.fault());
  return packets;
}

// What comes out is pings, farewells, the HTTP head, and frames that hold what the check admits.
void ReadFrames(unsigned flags, std::string_view bytes) {
  InputGate gate((flags & kV5) != 0 ? ProtocolVersion::k5 : ProtocolVersion::k311,
                 mqtt::Framing::kWebSocket);
  std::string input = "HTTP/1.1 101 x\r\n\r\n";
  input += bytes;
  std::size_t at = 0;
  const auto source = [&](void* buffer, std::size_t size) -> ssize_t {
    fuzz::Require(size > 0);
    const std::size_t some = std::min(size, input.size() - at);
    if (some == 0) errno = EAGAIN;
    std::memcpy(buffer, input.data() + at, some);
    at += some;
    return some == 0 ? -1 : static_cast<ssize_t>(some);
  };
  std::string output;
  std::array<char, 300> block{};
  for (ssize_t got = 0; (got = gate.Read(block.data(), block.size(), source)) > 0;) {
    output.append(block.data(), static_cast<std::size_t>(got));
  }
  fuzz::Require(output.starts_with("HTTP/1.1 101 x\r\n\r\n"));
  output.erase(0, 18);
  PacketCheck check((flags & kV5) != 0 ? ProtocolVersion::k5 : ProtocolVersion::k311);
  for (std::string_view left = output; !left.empty();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(left[i]); };
    fuzz::Require(left.size() >= 2 && byte(1) <= 126);
    std::size_t head = 2;
    std::size_t length = byte(1);
    if (length == 126) {
      length = byte(2) * 256U + byte(3);
      head = 4;
    }
    fuzz::Require(left.size() >= head + length);
    if (byte(0) == 0x82) {
      fuzz::Require(Admit(check, left.substr(head, length)) && check.IsBetweenPackets());
    } else {
      fuzz::Require(byte(0) == 0x88 || byte(0) == 0x89);
    }
    left.remove_prefix(head + length);
  }
}

struct Pair {
  Pair() {
    std::array<int, 2> ends{};
    fuzz::Require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) ==
                  0);
    ours = mqtt::Descriptor(ends[0]);
    theirs = mqtt::Descriptor(ends[1]);
  }
  mqtt::Descriptor ours;
  mqtt::Descriptor theirs;
};

mqtt::PahoConnection Connect(Pair& pair, bool v5) {
  // One that stays: Paho takes itself down with its last client.
  static const MQTTClient keeper = [] {
    MQTTClient_init_options options = MQTTClient_init_options_initializer;
    options.do_openssl_init = 0;
    MQTTClient_global_init(&options);
    MQTTClient client = nullptr;
    MQTTClient_create(&client, "tcp://127.0.0.1:1883", "k", MQTTCLIENT_PERSISTENCE_NONE, nullptr);
    return client;
  }();
  fuzz::Require(keeper != nullptr);
  mqtt::PahoConnection connection;
  connection.tls = std::make_unique<mqtt::TlsWatch>("", false);
  connection.server.version = v5 ? ProtocolVersion::k5 : ProtocolVersion::k311;
  connection.input =
      std::make_unique<mqtt::PahoInput>(connection.server.version, mqtt::Framing::kNone);
  MQTTClient_createOptions create = MQTTClient_createOptions_initializer;
  create.MQTTVersion = v5 ? MQTTVERSION_5 : MQTTVERSION_3_1_1;
  MQTTClient client = nullptr;
  fuzz::Require(MQTTClient_createWithOptions(&client, "tcp://127.0.0.1:1883", "c",
                                             MQTTCLIENT_PERSISTENCE_NONE, nullptr, &create) == 0);
  MQTTClient_connectOptions options = MQTTClient_connectOptions_initializer;
  MQTTClient_connectOptions options5 = MQTTClient_connectOptions_initializer5;
  if (v5) options = options5;
  options.MQTTVersion = create.MQTTVersion;
  mqtt::PahoCall call(-1, std::chrono::steady_clock::now() + std::chrono::seconds(5));
  call.Feed(*connection.input);
  call.Adopt(std::move(pair.ours));
  int code = -1;
  if (v5) {
    MQTTResponse response = MQTTClient_connect5(client, &options, nullptr, nullptr);
    code = mqtt::ReasonCode(response);
    MQTTResponse_free(response);
  } else {
    code = MQTTClient_connect(client, &options);
  }
  if (code != MQTTCLIENT_SUCCESS) {
    MQTTClient_destroy(&client);
    connection.input.reset();
    return connection;
  }
  connection.client = client;
  connection.descriptor = call.descriptor();
  return connection;
}

// Paho gets the bytes, and survives them.
void FeedPaho(unsigned flags, std::string_view bytes) {
  const bool v5 = (flags & kV5) != 0;
  Pair pair;
  std::string sent;
  if ((flags & kOwnConnack) == 0) sent += Connack(v5);
  sent += bytes;
  const auto size = static_cast<ssize_t>(sent.size());
  fuzz::Require(send(pair.theirs.get(), sent.data(), sent.size(), MSG_NOSIGNAL) == size);
  shutdown(pair.theirs.get(), SHUT_WR);
  auto connection = Connect(pair, v5);
  if (connection.client == nullptr) return;
  mqtt::PahoSession session(std::move(connection), std::chrono::seconds(60), {});
  const auto soon = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  if ((flags & kPublishes) != 0) {
    for (const auto qos : {mqtt::Qos::kAtLeastOnce, mqtt::Qos::kExactlyOnce}) {
      static_cast<void>(session.Publish({"t", "p", qos}, mqtt::Retain::kNo, soon));
    }
  }
  const std::array<std::string, kFilters> filters = {"a", "b"};
  if ((flags & kSubscribes) != 0) {
    static_cast<void>(session.Subscribe(filters, mqtt::Qos::kExactlyOnce, soon));
  }
  if ((flags & kUnsubscribes) != 0) static_cast<void>(session.Unsubscribe(filters, soon));
  std::size_t received = 0;
  while (!session.lost()) {
    session.Step();
    while (const auto message = session.TakeReceived()) {
      received += message->topic.size() + message->payload.size();
    }
  }
  fuzz::Require(received <= sent.size());
}

}  // namespace

FUZZ(text) {
  constexpr std::size_t kLongest = 4096;
  if (text.empty() || text.size() > kLongest) return;
  const auto flags = static_cast<unsigned char>(text[0]);
  const std::string_view bytes = text.substr(1);
  std::string checked;
  if ((flags & kOwnConnack) == 0) checked += Connack((flags & kV5) != 0);
  checked += bytes;
  const int packets = CheckAlone(flags, checked);
  if ((flags & kWebSocket) != 0) return ReadFrames(flags, bytes);
  // Of what is refused with its first packet Paho gets a piece, which costs most of the time.
  const int own = (flags & kOwnConnack) == 0 ? 1 : 0;
  const std::size_t dice = std::hash<std::string_view>{}(text);
  if (packets <= own && dice % 16 != 0) return;
  // With a message in flight Paho takes 100 ms to believe that a connection is lost.
  FeedPaho(dice % 16'384 == 0 ? flags : flags & ~static_cast<unsigned>(kPublishes), bytes);
}
