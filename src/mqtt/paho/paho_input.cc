// How nothing reaches Paho that is not well framed.
//
// The problem. Paho believes what stands inside a packet: six bytes of a broker (30 04 00 01 61 80,
// on MQTT 5) make it decode what lies behind the packet, and copy -1 bytes. No release mends it
// (docs/reliability.md).
//
// The way out. Paho reads its connections by recv() and SSL_read(), and by nothing else. As in
// paho_sockets.cc these are defined here, and every byte goes through the connection's InputGate
// before Paho has it. What must not go on is the end of the connection to Paho, which it believes
// too. Bytes of nobody else are looked at: the thread must be inside a PahoCall, and the descriptor
// one that Paho connected within a PahoCall; PahoMutex() is held then, so that two threads never
// meet here.
//
// Paho reads a packet in four or five pieces, the first of them single bytes, and asks poll() before
// each packet. Over TCP more is read at once than it asks for, and it is served out of that; poll()
// tells it so (paho_sockets.cc). A message costs its listener a sixth less.
//
// Linking. recv() is defined in place of the C library's, which is weak in libc.a. SSL_read() of a
// static libssl cannot be defined twice: there the linker's --wrap leads Paho's calls here
// (CMakeLists.txt). Unlike the rest of what is put in place of system calls, this is compiled
// without FLEETPUB_FAST_CONNECT too.

#ifdef _FORTIFY_SOURCE
#undef _FORTIFY_SOURCE  // its inline recv() would be a second definition
#endif

#include "mqtt/paho/paho_input.h"

#include <dlfcn.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "mqtt/paho/paho_sockets.h"

namespace fleetpub::mqtt {
namespace {

// Guarded by PahoMutex().
std::vector<PahoInput*>& Inputs() {
  static std::vector<PahoInput*> inputs;
  return inputs;
}

}  // namespace

PahoInput::PahoInput(ProtocolVersion version, Framing framing) : gate_(version, framing) {
  Inputs().push_back(this);
}

PahoInput::~PahoInput() { std::erase(Inputs(), this); }

void PahoInput::Bind(int descriptor) {
  for (PahoInput* const other : Inputs()) {
    if (other->descriptor_ == descriptor) other->descriptor_ = -1;  // closed long ago
  }
  descriptor_ = descriptor;
}

struct Input {
  // Null when the call is not Paho's, or not for its connection.
  static PahoInput* Of(int descriptor) {
    if (!PahoCall::IsInside() || descriptor < 0) return nullptr;
    for (PahoInput* const input : Inputs()) {
      if (input->descriptor_ == descriptor) return input;
    }
    return nullptr;
  }
};

bool PahoInput::HasReadAhead(int descriptor) {
  const PahoInput* const input = Input::Of(descriptor);
  return input != nullptr && input->HasReadAhead();
}

ssize_t PahoInput::Receive(void* buffer, std::size_t size, const InputGate::Source& system) {
  return gate_.Read(buffer, size, [&](void* into, std::size_t count) {
    return ReceiveAhead(into, count, system);
  });
}

ssize_t PahoInput::Decrypt(void* buffer, std::size_t size, const InputGate::Source& library) {
  return gate_.Read(buffer, size, library);
}

// As recv() would: what is there, at most so much.
ssize_t PahoInput::ReceiveAhead(void* buffer, std::size_t size, const InputGate::Source& system) {
  if (!HasReadAhead()) {
    if (size == 0 || size >= kMostAhead || !PahoCall::Supported()) return system(buffer, size);
    const ssize_t got = system(ahead_.get(), kMostAhead);
    if (got <= 0) return got;
    ahead_at_ = 0;
    ahead_end_ = static_cast<std::size_t>(got);
  }
  auto* const bytes = static_cast<char*>(buffer);
  const std::size_t some = std::min(size, ahead_end_ - ahead_at_);
  std::copy_n(ahead_.get() + ahead_at_, some, bytes);
  ahead_at_ += some;
  if (some == size) return static_cast<ssize_t>(some);
  const ssize_t more = system(bytes + some, size - some);
  return static_cast<ssize_t>(some) + std::max<ssize_t>(more, 0);
}

}  // namespace fleetpub::mqtt

using fleetpub::mqtt::Input;

#define FLEETPUB_INTERPOSE extern "C" __attribute__((used, visibility("default")))

FLEETPUB_INTERPOSE ssize_t recv(int descriptor, void* buffer, size_t size, int flags) {
  const auto system = [=](void* into, std::size_t count) {
    return static_cast<ssize_t>(
        syscall(SYS_recvfrom, descriptor, into, count, flags, nullptr, nullptr));
  };
  auto* const input = flags == 0 ? Input::Of(descriptor) : nullptr;
  return input == nullptr ? system(buffer, size) : input->Receive(buffer, size, system);
}

#ifdef FLEETPUB_WRAP_SSL_READ
extern "C" int __real_SSL_read(SSL* ssl, void* buffer, int size);
#define FLEETPUB_SSL_READ __wrap_SSL_read
#else
#define FLEETPUB_SSL_READ SSL_read
#endif

FLEETPUB_INTERPOSE int FLEETPUB_SSL_READ(SSL* ssl, void* buffer, int size) {
#ifdef FLEETPUB_WRAP_SSL_READ
  constexpr auto real = __real_SSL_read;
#else
  static const auto real =
      reinterpret_cast<int (*)(SSL*, void*, int)>(dlsym(RTLD_NEXT, "SSL_read"));
  if (real == nullptr) return -1;
#endif
  auto* const input = fleetpub::mqtt::PahoCall::IsInside() ? Input::Of(SSL_get_fd(ssl)) : nullptr;
  if (input == nullptr || size < 0) return real(ssl, buffer, size);
  const auto library = [ssl](void* into, std::size_t count) {
    return static_cast<ssize_t>(real(ssl, into, static_cast<int>(count)));
  };
  return static_cast<int>(input->Decrypt(buffer, static_cast<std::size_t>(size), library));
}
