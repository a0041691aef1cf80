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
  static InputGate* Of(int descriptor) {
    if (!PahoCall::IsInside() || descriptor < 0) return nullptr;
    for (PahoInput* const input : Inputs()) {
      if (input->descriptor_ == descriptor) return &input->gate_;
    }
    return nullptr;
  }
};

}  // namespace fleetpub::mqtt

using fleetpub::mqtt::Input;

#define FLEETPUB_INTERPOSE extern "C" __attribute__((used, visibility("default")))

FLEETPUB_INTERPOSE ssize_t recv(int descriptor, void* buffer, size_t size, int flags) {
  const auto system = [=](void* into, std::size_t count) {
    return static_cast<ssize_t>(
        syscall(SYS_recvfrom, descriptor, into, count, flags, nullptr, nullptr));
  };
  auto* const gate = flags == 0 ? Input::Of(descriptor) : nullptr;
  return gate == nullptr ? system(buffer, size) : gate->Read(buffer, size, system);
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
  auto* const gate = fleetpub::mqtt::PahoCall::IsInside() ? Input::Of(SSL_get_fd(ssl)) : nullptr;
  if (gate == nullptr || size < 0) return real(ssl, buffer, size);
  const auto library = [ssl](void* into, std::size_t count) {
    return static_cast<ssize_t>(real(ssl, into, static_cast<int>(count)));
  };
  return static_cast<int>(gate->Read(buffer, static_cast<std::size_t>(size), library));
}
