#include "base/uuid.h"

#include <sys/random.h>

#include <array>
#include <span>
#include <stdexcept>
#include <string_view>

namespace fleetpub::base {
namespace {

constexpr std::size_t kBytes = 16;

// Asking the system for each costs more than the rest of the work. It gives 256 bytes in one go.
std::span<unsigned char, kBytes> RandomBytes() {
  thread_local std::array<unsigned char, 16 * kBytes> pool;
  thread_local std::size_t left = 0;
  if (left == 0) {
    if (getrandom(pool.data(), pool.size(), 0) != static_cast<ssize_t>(pool.size())) {
      throw std::runtime_error("the system gives no random numbers");
    }
    left = pool.size();
  }
  left -= kBytes;
  return std::span(pool).subspan(left).first<kBytes>();
}

}  // namespace

// Not libuuid: Paho's static library defines two of its names for itself, and a static link cannot
// have both.
std::string RandomUuid() {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const auto bytes = RandomBytes();
  bytes[6] = static_cast<unsigned char>((bytes[6] & 0x0FU) | 0x40U);  // version 4
  bytes[8] = static_cast<unsigned char>((bytes[8] & 0x3FU) | 0x80U);  // variant of RFC 4122
  std::string text;
  text.reserve(2 * kBytes + 4);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += kDigits[bytes[i] >> 4U];
    text += kDigits[bytes[i] & 0x0FU];
  }
  return text;
}

}  // namespace fleetpub::base
