#include "support/front.h"

#include <openssl/evp.h>
#include <openssl/sha.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <memory>

#include "mqtt/descriptor.h"
#include "support/relay.h"

namespace fleetpub::testing {
namespace {

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;
using Session = std::unique_ptr<SSL, decltype(&SSL_free)>;

// The client's side: with TLS or without.
class Client {
 public:
  Client(int socket, const std::string& certificate, const std::string& key) : socket_(socket) {
    if (certificate.empty()) return;
    context_.reset(SSL_CTX_new(TLS_server_method()));
    SSL_CTX_use_certificate_chain_file(context_.get(), certificate.c_str());
    SSL_CTX_use_PrivateKey_file(context_.get(), key.c_str(), SSL_FILETYPE_PEM);
    session_.reset(SSL_new(context_.get()));
    SSL_set_fd(session_.get(), socket);
    is_open_ = SSL_accept(session_.get()) == 1;
  }

  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] bool HasMore() const { return session_ && SSL_pending(session_.get()) > 0; }

  [[nodiscard]] std::string Read() const {
    if (!session_) return ReadSome(socket_);
    std::array<char, 65'536> block;
    const int got = SSL_read(session_.get(), block.data(), static_cast<int>(block.size()));
    return got <= 0 ? std::string() : std::string(block.data(), static_cast<std::size_t>(got));
  }

  bool Write(std::string_view bytes) const {
    if (!session_) return WriteTo(socket_, bytes);
    return SSL_write(session_.get(), bytes.data(), static_cast<int>(bytes.size())) > 0;
  }

 private:
  int socket_;
  bool is_open_ = true;
  Context context_{nullptr, SSL_CTX_free};
  Session session_{nullptr, SSL_free};
};

// Takes whole frames, which a client masks (§5.3), out of what came; "" when there is none.
std::string TakeFrame(std::string& bytes) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  if (bytes.size() < 2) return {};
  const std::size_t extra = (at(1) & 0x7F) == 126 ? 2 : ((at(1) & 0x7F) == 127 ? 8 : 0);
  if (bytes.size() < 2 + extra + 4) return {};
  std::size_t length = extra == 0 ? at(1) & 0x7FU : 0;
  for (std::size_t i = 0; i < extra; ++i) length = length << 8 | at(2 + i);
  const std::size_t mask = 2 + extra;
  if (bytes.size() < mask + 4 + length) return {};
  std::string data = bytes.substr(mask + 4, length);
  for (std::size_t i = 0; i < length; ++i) data[i] ^= bytes[mask + i % 4];
  bytes.erase(0, mask + 4 + length);
  return data;
}

}  // namespace

std::string WebSocketAnswer(const std::string& request) {
  const std::string_view name = "Sec-WebSocket-Key: ";
  const std::size_t start = request.find(name) + name.size();
  const std::string key = request.substr(start, request.find('\r', start) - start) +
                          "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, SHA_DIGEST_LENGTH> digest{};
  SHA1(reinterpret_cast<const unsigned char*>(key.data()), key.size(), digest.data());
  std::array<unsigned char, 64> text{};
  const int length = EVP_EncodeBlock(text.data(), digest.data(), static_cast<int>(digest.size()));
  return "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Accept: " +
         std::string(reinterpret_cast<const char*>(text.data()), static_cast<std::size_t>(length)) +
         "\r\n\r\n";
}

std::string WebSocketFrame(std::string_view data, int first) {
  std::string frame = {static_cast<char>(first)};
  std::size_t bytes = 0;
  if (data.size() >= 126) bytes = data.size() > 0xFFFF ? 8 : 2;
  frame += static_cast<char>(bytes == 0 ? data.size() : (bytes == 2 ? 126U : 127U));
  while (bytes-- > 0) frame += static_cast<char>(data.size() >> (8 * bytes) & 0xFF);
  return frame.append(data);
}

void Front::Pass(int socket) const {
  const bool tls = scheme_ == "mqtts" || scheme_ == "wss";
  const bool frames = scheme_ == "ws" || scheme_ == "wss";
  const mqtt::Descriptor broker = ConnectTo(port_);
  const Client client(socket, tls ? certificate_ : std::string(), key_);
  if (!broker.open() || !client.is_open()) return;
  if (frames && !client.Write(WebSocketAnswer(client.Read()))) return;
  std::string heard;
  while (true) {
    std::array<pollfd, 2> polled = {pollfd{socket, POLLIN, 0}, pollfd{broker.get(), POLLIN, 0}};
    if (poll(polled.data(), polled.size(), client.HasMore() ? 0 : -1) < 0) return;
    if (polled[0].revents != 0 || client.HasMore()) {
      const std::string more = client.Read();
      if (more.empty()) return;
      if (!frames && !WriteTo(broker.get(), more)) return;
      if (frames) heard += more;
      for (std::string data; frames && !(data = TakeFrame(heard)).empty();) {
        if (!WriteTo(broker.get(), data)) return;
      }
    }
    if (polled[1].revents != 0) {
      const std::string more = ReadSome(broker.get());
      if (more.empty()) return;
      if (!client.Write(frames ? WebSocketFrame(more) : more)) return;
    }
  }
}

}  // namespace fleetpub::testing
