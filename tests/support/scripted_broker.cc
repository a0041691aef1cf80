#include "support/scripted_broker.h"

#include <thread>

namespace fleetpub::testing {
namespace {

constexpr int kConnect = 1;
constexpr int kPublish = 3;
constexpr int kSubscribe = 8;
constexpr int kPing = 12;
constexpr int kQosBits = 6;

std::size_t Number(const std::string& bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes.at(at)) * 256U +
         static_cast<unsigned char>(bytes.at(at + 1));
}

std::string Answer(int first, const std::string& body) {
  return static_cast<char>(first) + std::string(1, static_cast<char>(body.size())) + body;
}

// 3.1.1 §3.9, MQTT 5 §3.9: a code per filter. SUBSCRIBE has no properties here.
std::string Suback(const std::string& subscribe, int code, bool v5) {
  const std::string properties(v5 ? 1 : 0, '\0');
  std::string body = subscribe.substr(0, 2) + properties;
  for (std::size_t at = 2 + properties.size(); at + 2 < subscribe.size();) {
    at += 2 + Number(subscribe, at) + 1;
    body += static_cast<char>(code);
  }
  return Answer(0x90, body);
}

std::string Puback(const Packet& publish, int code, bool v5) {
  std::string body = publish.body.substr(2 + Number(publish.body, 0), 2);
  if (v5 && code != 0) body += static_cast<char>(code);
  return Answer(0x40, body);
}

}  // namespace

bool PacketReader::Fill(std::size_t size) {
  while (bytes_.size() < size) {
    const std::string more = ReadSome(socket_);
    if (more.empty()) return false;
    bytes_ += more;
  }
  return true;
}

std::optional<Packet> PacketReader::Next() {
  std::size_t length = 0;
  std::size_t head = 1;
  for (int shift = 0;; shift += 7) {
    if (!Fill(head + 1)) return std::nullopt;
    const auto byte = static_cast<unsigned char>(bytes_[head++]);
    length += static_cast<std::size_t>(byte & 0x7FU) << shift;
    if (byte < 0x80) break;
  }
  if (!Fill(head + length)) return std::nullopt;
  const auto first = static_cast<unsigned char>(bytes_[0]);
  Packet packet{.type = first >> 4, .flags = first & 0xF, .body = bytes_.substr(head, length)};
  bytes_.erase(0, head + length);
  return packet;
}

void ScriptedBroker::Serve(int socket) {
  PacketReader reader(socket);
  bool v5 = false;
  while (const auto packet = reader.Next()) {
    constexpr std::size_t kLevel = 6;  // behind the protocol's name
    if (packet->type == kConnect) v5 = packet->body.at(kLevel) == 5;
    const std::string answer = AnswerTo(socket, *packet, v5);
    const std::string other = packet->type == kPublish     ? script_.on_publish
                              : packet->type == kSubscribe ? script_.on_subscribe
                                                           : std::string();
    if (other.empty()) {
      if (!answer.empty()) WriteTo(socket, answer);
    } else {
      for (int i = 0; i < script_.times && WriteTo(socket, other); ++i) {
      }
    }
    if (packet->type == script_.hangs_up_after) return;
  }
}

void ScriptedBroker::PassTime(int socket) const {
  constexpr std::chrono::milliseconds kPiece{20};
  auto left = script_.before_suback;
  for (; !script_.meanwhile.empty() && left > kPiece; left -= kPiece) {
    std::this_thread::sleep_for(kPiece);
    WriteTo(socket, script_.meanwhile);
  }
  std::this_thread::sleep_for(left);
}

std::string ScriptedBroker::AnswerTo(int socket, const Packet& packet, bool v5) {
  switch (packet.type) {
    case kConnect:
      ++connected_;
      return v5 ? BrokenBroker::Connack5(0) : BrokenBroker::Connack(0);
    case kPublish:
      ++published_;
      if ((packet.flags & kQosBits) == 0 || !script_.answers_publish) return {};
      std::this_thread::sleep_for(script_.before_puback);
      return Puback(packet, script_.puback, v5);
    case kSubscribe: {
      PassTime(socket);
      const std::string suback = Suback(packet.body, script_.suback, v5);
      const bool is_by_name = packet.body.find_first_of("+#") == std::string::npos;
      if (!is_by_name || script_.by_name.empty()) return suback + script_.after_suback;
      WriteTo(socket, suback);
      std::this_thread::sleep_for(script_.before_by_name);
      return script_.by_name;
    }
    case kPing:
      return Answer(0xD0, "");
    default:
      return {};
  }
}

}  // namespace fleetpub::testing
