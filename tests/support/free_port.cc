#include "support/free_port.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <mutex>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace fleetpub::testing {
namespace {

// Below what Linux gives to outgoing connections and to whoever asks for any port (32768 to 60999).
constexpr int kFirst = 10000;
constexpr int kBlocks = 440;
constexpr int kBlockSize = 50;

// Whether no other process has the block. A name in the kernel's own space, which leaves no file: it goes with the
// process, however that ends.
bool Claim(int block) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = "fleetpub-test-ports-" + std::to_string(block);
  name.copy(address.sun_path + 1, name.size());
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), length) != 0) {
    close(socket);
    return false;
  }
  static std::vector<int> held;
  held.push_back(socket);
  return true;
}

int ClaimAnyBlock() {
  int block = static_cast<int>(std::random_device{}() % kBlocks);
  for (int tried = 0; tried < kBlocks; ++tried, block = (block + 1) % kBlocks) {
    if (Claim(block)) return block;
  }
  throw std::runtime_error("other tests have every port");
}

bool IsFree(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool is_free =
      bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(listener);
  return is_free;
}

}  // namespace

std::uint16_t FreePort() {
  static std::mutex mutex;
  static int next = 0;
  static int end = 0;
  const std::lock_guard lock(mutex);
  for (;;) {
    if (next == end) {
      next = kFirst + ClaimAnyBlock() * kBlockSize;
      end = next + kBlockSize;
    }
    const auto port = static_cast<std::uint16_t>(next++);
    if (IsFree(port)) return port;
  }
}

}  // namespace fleetpub::testing
