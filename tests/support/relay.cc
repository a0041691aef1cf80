#include "support/relay.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <deque>

namespace fleetpub::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kGlance{20};  // how soon a dead network is noticed, or a live one again

// A wire holds nothing back: no small packet waits for the acknowledgement of the one before.
void PassAtOnce(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket, IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

// What is under way in one direction. Its last piece is empty: the end.
class Direction {
 public:
  Direction(int from, int to, milliseconds delay, std::size_t bytes_per_ms)
      : from_(from), to_(to), delay_(delay), bytes_per_ms_(bytes_per_ms) {}

  [[nodiscard]] int from() const { return from_; }
  [[nodiscard]] bool ended() const { return ended_; }

  void Take() {
    std::string bytes = ReadSome(from_);
    PassAtOnce(from_);  // the kernel forgets it
    ended_ = bytes.empty();
    auto due = steady_clock::now() + delay_;
    while (bytes_per_ms_ > 0 && !bytes.empty()) {
      due = std::max(due, last_due_ + milliseconds(1));
      last_due_ = due;
      under_way_.push_back({due, bytes.substr(0, bytes_per_ms_)});
      bytes.erase(0, bytes_per_ms_);
    }
    if (bytes_per_ms_ == 0 || ended_) {
      under_way_.push_back({std::max(due, last_due_), std::move(bytes)});
    }
  }

  /// False when the end has arrived.
  [[nodiscard]] bool Deliver() {
    while (!under_way_.empty() && under_way_.front().due <= steady_clock::now()) {
      if (under_way_.front().bytes.empty()) return false;
      WriteTo(to_, under_way_.front().bytes);
      under_way_.pop_front();
    }
    return true;
  }

  [[nodiscard]] milliseconds Patience() const {
    if (under_way_.empty()) return kGlance;
    const auto left = std::chrono::ceil<milliseconds>(under_way_.front().due - steady_clock::now());
    return std::clamp(left, milliseconds(0), kGlance);
  }

 private:
  struct Piece {
    steady_clock::time_point due;
    std::string bytes;
  };

  int from_;
  int to_;
  milliseconds delay_;
  std::size_t bytes_per_ms_;
  steady_clock::time_point last_due_;
  std::deque<Piece> under_way_;
  bool ended_ = false;
};

}  // namespace

mqtt::Descriptor ConnectTo(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  mqtt::Descriptor descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (connect(descriptor.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return {};
  }
  return descriptor;
}

void Relay::Pass(int socket) {
  ++connections_;
  const int generation = generation_;
  const mqtt::Descriptor broker = ConnectTo(port_);
  if (!broker.open()) return;
  PassAtOnce(socket);
  PassAtOnce(broker.get());
  std::array<Direction, 2> directions = {Direction(socket, broker.get(), one_way_, bytes_per_ms_),
                                         Direction(broker.get(), socket, one_way_, bytes_per_ms_)};
  while (true) {
    const bool dead = dead_ || generation != generation_;
    std::array<pollfd, 2> polled{};
    auto patience = kGlance;
    for (std::size_t i = 0; i < polled.size(); ++i) {
      const bool listens = !dead && !directions[i].ended();
      polled[i] = {.fd = listens ? directions[i].from() : -1, .events = POLLIN, .revents = 0};
      patience = std::min(patience, directions[i].Patience());
    }
    // The client's end is heeded also while nothing gets through: the test may be over.
    if (dead) {
      polled[0] = {.fd = socket, .events = POLLRDHUP, .revents = 0};
      patience = kGlance;
    }
    if (poll(polled.data(), polled.size(), static_cast<int>(patience.count())) < 0) return;
    if (dead && polled[0].revents != 0) return;
    if (dead) continue;
    for (std::size_t i = 0; i < polled.size(); ++i) {
      if (polled[i].revents != 0) directions[i].Take();
      if (!directions[i].Deliver()) return;
    }
  }
}

}  // namespace fleetpub::testing
