// The floor of commanding with tracker: a raw socket, ready packets, no ledger, no validation,
// no JSON.
//
//   raw_commander PORT COUNT
//   raw_commander PORT COUNT QOS
//
// Subscribes to the states of all 3.0 robots, sends startPause to KIT/000001 … in bursts of 500,
// and ends when every one of them has reported its action FINISHED. With QOS 0 or 1 it only sends
// packets that were made beforehand, and ends when the broker has taken them.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

std::string Length(std::size_t length) {
  std::string bytes;
  do {
    const auto digit = static_cast<unsigned char>(length % 128);
    length /= 128;
    bytes += static_cast<char>(length > 0 ? digit | 0x80 : digit);
  } while (length > 0);
  return bytes;
}

std::string Text(std::string_view text) {
  return std::string{static_cast<char>(text.size() >> 8), static_cast<char>(text.size() & 0xFF)} +
         std::string(text);
}

std::string Packet(unsigned char type, const std::string& body) {
  return static_cast<char>(type) + Length(body.size()) + body;
}

std::string Command(int robot, int qos = 0) {
  const int packet = robot % 65535 + 1;  // 0 is none
  const std::string id =
      qos == 0 ? "" : std::string{static_cast<char>(packet >> 8), static_cast<char>(packet & 0xFF)};
  return Packet(
      qos == 0 ? 0x30 : 0x32,
      Text(fmt::format("vda5050/v3/KIT/{:06}/instantActions", robot)) + id +
          fmt::format(R"({{"headerId":0,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0",)"
                      R"("manufacturer":"KIT","serialNumber":"{:06}","actions":[{{"actionType":)"
                      R"("startPause","actionId":"raw-{}-{:06}","blockingType":"NONE"}}]}})",
                      robot, getpid(), robot));
}

class Socket {
 public:
  explicit Socket(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) std::exit(1);
  }
  void Write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t count = write(socket_, bytes.data(), bytes.size());
      if (count <= 0) std::exit(1);
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  // The next packet: its body, valid until the next call.
  std::string_view Read() {
    for (;;) {
      std::size_t length = 0;
      std::size_t header = 1;
      for (std::size_t shift = 0; header < Available(); shift += 7) {
        const auto byte = static_cast<unsigned char>(buffer_[begin_ + header++]);
        length |= static_cast<std::size_t>(byte & 0x7F) << shift;
        if ((byte & 0x80) != 0) continue;
        if (Available() < header + length) break;
        const std::string_view body(buffer_.data() + begin_ + header, length);
        begin_ += header + length;
        return body;
      }
      Fill();
    }
  }

 private:
  [[nodiscard]] std::size_t Available() const { return buffer_.size() - begin_; }
  void Fill() {
    buffer_.erase(0, begin_);
    begin_ = 0;
    const std::size_t before = buffer_.size();
    buffer_.resize(before + 65536);
    const ssize_t count = read(socket_, buffer_.data() + before, 65536);
    if (count <= 0) std::exit(1);
    buffer_.resize(before + static_cast<std::size_t>(count));
  }

  int socket_;
  std::string buffer_;
  std::size_t begin_ = 0;
};

// Ready packets; at QoS 1 up to 500 await their acknowledgement.
void SendOnly(Socket& socket, int count, int qos) {
  for (int sent = 0; sent < count;) {
    std::string burst;
    const int until = std::min(count, sent + 500);
    for (int robot = sent + 1; robot <= until; ++robot) burst += Command(robot, qos);
    socket.Write(burst);
    for (int i = sent; qos > 0 && i < until; ++i) socket.Read();
    sent = until;
  }
  socket.Write(std::string("\xC0\x00", 2));  // the answer to a ping: all before it was taken
  socket.Read();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    fmt::print(stderr, "usage: raw_commander PORT COUNT [QOS]\n");
    return 2;
  }
  const int count = std::atoi(argv[2]);
  Socket socket(std::atoi(argv[1]));
  socket.Write(Packet(0x10, Text("MQTT") + std::string("\x04\x02\x00\x3C", 4) +
                                Text(fmt::format("raw-{}", getpid()))));
  socket.Read();
  if (argc == 4) {
    SendOnly(socket, count, std::atoi(argv[3]));
    return 0;
  }
  const std::string filter = count == 1 ? "vda5050/v3/KIT/000001/state" : "vda5050/v3/+/+/state";
  socket.Write(Packet(0x82, std::string("\x00\x01", 2) + Text(filter) + std::string(1, '\0')));
  socket.Read();
  const std::string ours = fmt::format("raw-{}-", getpid());
  for (int sent = 0; sent < count;) {
    std::string burst;
    const int until = std::min(count, sent + 500);
    for (int robot = sent + 1; robot <= until; ++robot) burst += Command(robot);
    socket.Write(burst);
    for (int finished = sent; finished < until;) {
      const std::string_view state = socket.Read();
      const bool done = state.find(ours) != std::string_view::npos &&
                        state.find("\"FINISHED\"") != std::string_view::npos;
      if (done) ++finished;
    }
    sent = until;
  }
  return 0;
}
