// How Paho is made fast and punctual without touching it.
//
// The problem. paho-mqtt-c (every release up to 1.3.15) connects a non-blocking socket and then
// polls it for *reading* only, which a socket that has just connected never is: each
// MQTTClient_connect() sleeps out its 100 ms poll, while mosquitto_pub does its whole job in one.
// No option avoids it. Its connect timeout counts whole seconds and excludes the name lookup; its
// other waits (SUBACK, back-pressure) are 5 s at least or have no end. It takes one address of a
// host and gives up when that one is dead. It tells "-1" of whatever went wrong.
//
// The way out. Paho calls connect(), poll(), writev() and getaddrinfo() by their names. This file
// defines them in the executable, and the linker and the dynamic loader both prefer an executable's
// own definition to the C library's: Paho's calls arrive here, from libpaho-mqtt3cs.a and from
// libpaho-mqtt3cs.so, also under the sanitizers (whose interceptors are only weak) and with
// link-time optimisation. `used` keeps the definitions from an optimiser that sees no caller.
// Nobody else may notice: libpq, OpenSSL's own look-ups and the rest of the program call the same
// names. So everything below does the plain system call unless the calling *thread* is inside a
// PahoCall *and* the descriptor is that call's.
//
//   connect()      tcp_connect.cc has connected a socket before Paho was entered (all addresses, exact
//                  errors, a deadline). It is put in place of Paho's unconnected one by dup3(). The answer is
//                  EINPROGRESS, *not* 0: Paho's path for 0 is hardly ever taken elsewhere and is
//                  wrong (TLS connects fail half of the time, WebSockets always). Its state machine
//                  then runs as on any other day.
//   poll()         The first time that Paho polls the new connection for reading, it is answered at
//                  once: that is the 100 ms. Every wait is cut at the deadline; then the connection is shut down,
//                  Paho reads the end and gives up. The first byte of the first answer is looked at
//                  before Paho sees it: an SSH server's greeting is to Paho the start of a packet
//                  whose rest never comes. What paho_input.cc has read ahead is readable, too.
//   writev()       Waits for room instead of writing short, which would cost Paho another 100 ms.
//                  (TLS writes through write(), which is left alone: the transport waits for room before it publishes.)
//   getaddrinfo()  The name has been looked up already. Paho needs an answer only to choose the
//                  family of the socket that connect() throws away, and still needs the name itself for SNI, the
//                  certificate and `Host:`.
//
// Raw system calls are used in place of the C library's functions, since a static executable has no
// dlsym(RTLD_NEXT). For the same reason FLEETPUB_STATIC leaves getaddrinfo() out (libc.a would
// define it twice): there, TLS and WebSocket connections to a host by name look it up a second
// time.
//
// Without FLEETPUB_FAST_CONNECT none of this is compiled but a connect() that tells paho_input.cc
// of the descriptor: correct, 100 ms slower, and blunt about deadlines.

#ifdef _FORTIFY_SOURCE
#undef _FORTIFY_SOURCE  // its inline poll() would be a second definition
#endif

#include "mqtt/paho/paho_sockets.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "mqtt/paho/paho_input.h"
#include "mqtt/tcp_connect.h"

namespace fleetpub::mqtt {
namespace {

thread_local PahoCall* current_call = nullptr;

}  // namespace

PahoCall::PahoCall(int descriptor, Deadline deadline)
    : descriptor_(descriptor), deadline_(deadline) {
  current_call = this;
}

PahoCall::~PahoCall() { current_call = nullptr; }

bool PahoCall::IsInside() { return current_call != nullptr; }

void PahoCall::Abort() {
  if (descriptor_ >= 0) shutdown(descriptor_, SHUT_RDWR);
}

void PahoCall::Connecting(int descriptor) {
  if (current_call != nullptr && current_call->input_ != nullptr) {
    current_call->input_->Bind(descriptor);
  }
}

#ifndef FLEETPUB_FAST_CONNECT

bool PahoCall::Supported() { return false; }

struct Interposed {
  static bool Connect(int /*descriptor*/) { return false; }
};

#else

bool PahoCall::Supported() { return true; }

namespace {

int RawPoll(pollfd* descriptors, nfds_t count, int timeout) {
#ifdef SYS_poll
  return static_cast<int>(syscall(SYS_poll, descriptors, count, timeout));
#else
  timespec time{timeout / 1000, (timeout % 1000) * 1'000'000L};
  return static_cast<int>(
      syscall(SYS_ppoll, descriptors, count, timeout < 0 ? nullptr : &time, nullptr, 0));
#endif
}

}  // namespace

// What the system calls mean inside a PahoCall.
struct Interposed {
  static PahoCall* CallOn(int descriptor) {
    PahoCall* const call = current_call;
    return call != nullptr && descriptor >= 0 && call->descriptor_ == descriptor ? call : nullptr;
  }

  static bool Connect(int descriptor) {
    PahoCall* const call = current_call;
    if (call == nullptr || !call->adopted_.open()) return false;
    const Descriptor adopted = std::move(call->adopted_);
    if (dup3(adopted.get(), descriptor, O_CLOEXEC) < 0) return false;
    call->descriptor_ = descriptor;
    call->just_connected_ = true;
    return true;
  }

  static pollfd* FindReading(pollfd* descriptors, nfds_t count) {
    for (nfds_t i = 0; i < count; ++i) {
      if (CallOn(descriptors[i].fd) != nullptr && (descriptors[i].events & POLLIN) != 0) {
        return &descriptors[i];
      }
    }
    return nullptr;
  }

  static int Poll(pollfd* descriptors, nfds_t count, int timeout) {
    pollfd* const ours = current_call == nullptr ? nullptr : FindReading(descriptors, count);
    if (ours == nullptr) return RawPoll(descriptors, count, timeout);
    PahoCall& call = *current_call;
    if (PahoInput::HasReadAhead(ours->fd)) {
      const int ready = count > 1 ? RawPoll(descriptors, count, 0) : 0;
      if (ready < 0) return ready;
      const bool is_counted = count > 1 && ours->revents != 0;
      ours->revents = POLLIN;
      return Readable(call, is_counted ? ready : ready + 1);
    }
    if (std::exchange(call.just_connected_, false)) timeout = 0;
    if (timeout != 0) {
      const int left = MillisecondsUntil(call.deadline_);
      if (left == 0) {
        call.expired_ = true;
        call.Abort();
        // As the kernel would say, were it able to: Paho reads the end, whether or not it may write.
        for (nfds_t i = 0; i < count; ++i) descriptors[i].revents = 0;
        ours->revents = POLLIN | POLLHUP;
        return 1;
      }
      if (timeout < 0 || timeout > left) timeout = left;
    }
    int ready = RawPoll(descriptors, count, 0);
    if (ready == 0 && timeout != 0) {
      // A broker that sends in two pieces (SUBACK, then what is retained) waits for the first one's
      // acknowledgement, which our kernel would put off for 40 ms.
      AcknowledgeAtOnce(ours->fd);
      ready = RawPoll(descriptors, count, timeout);
    }
    if (ready < 0) return ready;
    if (ours->revents != 0) return Readable(call, ready);
    if (std::exchange(call.probe_, false)) {
      ours->revents = POLLIN;
      ++ready;
    }
    return ready;
  }

  static int Readable(PahoCall& call, int ready) {
    call.readable_ = true;
    if (call.patience_.count() > 0) {
      const auto renewed = std::chrono::steady_clock::now() + call.patience_;
      call.deadline_ = std::max(call.deadline_, std::min(renewed, call.latest_));
    }
    CheckFirst(call);
    return ready;
  }

  static void CheckFirst(PahoCall& call) {
    if (call.expected_.empty()) return;
    unsigned char first = 0;
    if (recv(call.descriptor_, &first, 1, MSG_PEEK | MSG_DONTWAIT) != 1) return;
    if (call.expected_.find(static_cast<char>(first)) == std::string_view::npos) {
      call.wrong_first_ = first;
      call.Abort();
    }
    call.expected_ = {};
  }

  // Writes everything, or fails and leaves a connection that is fit for nothing but closing.
  static ssize_t Write(PahoCall& call, const iovec* parts, int count) {
    std::size_t total = 0;
    for (int i = 0; i < count; ++i) total += parts[i].iov_len;
    std::size_t written = 0;
    while (true) {
      iovec rest[16];
      const int left = Rest(parts, count, written, rest);
      const auto done = syscall(SYS_writev, call.descriptor_, rest, left);
      if (done >= 0) written += static_cast<std::size_t>(done);
      if (written == total) return static_cast<ssize_t>(written);
      if (done < 0 && errno == EINTR) continue;
      if (done < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return -1;
      if (WaitFor(call.descriptor_, POLLOUT, call.deadline_) == 0) {
        call.expired_ = true;
        call.Abort();
        errno = ETIMEDOUT;
        return -1;
      }
    }
  }

  // The parts without the first `skip` bytes. Paho has five at most.
  static int Rest(const iovec* parts, int count, std::size_t skip, iovec (&rest)[16]) {
    int used = 0;
    for (int i = 0; i < count && used < 16; ++i) {
      if (skip >= parts[i].iov_len) {
        skip -= parts[i].iov_len;
        continue;
      }
      rest[used++] = {static_cast<char*>(parts[i].iov_base) + skip, parts[i].iov_len - skip};
      skip = 0;
    }
    return used;
  }

  static bool HasAddress() { return current_call != nullptr && current_call->adopted_.open(); }

  // One block, as freeaddrinfo() of every C library for Linux expects it.
  static int AnyAddress(addrinfo** result) {
    struct Block {
      addrinfo info;
      sockaddr_in address;
    };
    auto* const block = static_cast<Block*>(std::calloc(1, sizeof(Block)));
    if (block == nullptr) return EAI_MEMORY;
    block->address.sin_family = AF_INET;
    block->info.ai_family = AF_INET;
    block->info.ai_socktype = SOCK_STREAM;
    block->info.ai_addr = reinterpret_cast<sockaddr*>(&block->address);
    block->info.ai_addrlen = sizeof(sockaddr_in);
    *result = &block->info;
    return 0;
  }
};

#endif  // FLEETPUB_FAST_CONNECT

}  // namespace fleetpub::mqtt

using fleetpub::mqtt::Interposed;

#define FLEETPUB_INTERPOSE extern "C" __attribute__((used, visibility("default")))

FLEETPUB_INTERPOSE int connect(int descriptor, const sockaddr* address, socklen_t length) {
  fleetpub::mqtt::PahoCall::Connecting(descriptor);
  if (Interposed::Connect(descriptor)) {
    errno = EINPROGRESS;
    return -1;
  }
  return static_cast<int>(syscall(SYS_connect, descriptor, address, length));
}

#ifdef FLEETPUB_FAST_CONNECT

FLEETPUB_INTERPOSE int poll(pollfd* descriptors, nfds_t count, int timeout) {
  return Interposed::Poll(descriptors, count, timeout);
}

FLEETPUB_INTERPOSE ssize_t writev(int descriptor, const iovec* parts, int count) {
  auto* const call = Interposed::CallOn(descriptor);
  if (call == nullptr || count > 16) return syscall(SYS_writev, descriptor, parts, count);
  return Interposed::Write(*call, parts, count);
}

#ifndef FLEETPUB_STATIC
FLEETPUB_INTERPOSE int getaddrinfo(const char* node, const char* service, const addrinfo* hints,
                                   addrinfo** result) {
  if (Interposed::HasAddress()) return Interposed::AnyAddress(result);
  using Function = int (*)(const char*, const char*, const addrinfo*, addrinfo**);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "getaddrinfo"));
  return real == nullptr ? EAI_FAIL : real(node, service, hints, result);
}
#endif

#endif  // FLEETPUB_FAST_CONNECT
