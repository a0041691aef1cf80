#include "mqtt/tcp_connect.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "base/text.h"

namespace fleetpub::mqtt {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kHeadStart{250};

tl::unexpected<Error> Unreachable(std::string cause, std::string detail = {}) {
  return Fail(ErrorKind::kBroker, std::move(cause), std::move(detail));
}

std::vector<Address> Copy(const addrinfo* list) {
  std::vector<Address> addresses;
  for (; list != nullptr; list = list->ai_next) {
    if (list->ai_addrlen > sizeof(sockaddr_storage)) continue;
    Address& address = addresses.emplace_back();
    std::memcpy(&address.storage, list->ai_addr, list->ai_addrlen);
    address.length = list->ai_addrlen;
  }
  return addresses;
}

// What the lookup thread leaves for whoever still waits.
struct LookupState {
  std::mutex mutex;
  std::condition_variable done;
  bool finished = false;
  int code = 0;
  int system_error = 0;
  std::vector<Address> addresses;
};

void RunLookup(LookupState& state, const std::string& host, std::uint16_t port, int flags) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const int code = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  const int system_error = errno;
  std::vector<Address> addresses = code == 0 ? Copy(list) : std::vector<Address>();
  if (code == 0) freeaddrinfo(list);
  const std::lock_guard lock(state.mutex);
  state.code = code;
  state.system_error = system_error;
  state.addresses = std::move(addresses);
  state.finished = true;
  state.done.notify_one();
}

Result<std::vector<Address>> ReadAddresses(const std::string& host, LookupState& state) {
  if (state.code == 0 && !state.addresses.empty()) return std::move(state.addresses);
  const std::string detail = state.code == EAI_SYSTEM
                                 ? std::generic_category().message(state.system_error)
                                 : std::string(gai_strerror(state.code));
  if (state.code == EAI_AGAIN || state.code == EAI_SYSTEM) {
    return Unreachable(
        fmt::format("the name {} could not be looked up: the name service fails", host), detail);
  }
  return Unreachable(fmt::format("the name {} is not known", host), detail);
}

Result<std::vector<Address>> LookupOnThread(const std::string& host, std::uint16_t port,
                                            Deadline deadline) {
  const auto state = std::make_shared<LookupState>();
  try {
    std::thread([state, host, port] { RunLookup(*state, host, port, AI_ADDRCONFIG); }).detach();
  } catch (const std::system_error& error) {
    return Unreachable("no thread for the name lookup", error.what());
  }
  std::unique_lock lock(state->mutex);
  state->done.wait_until(lock, deadline, [&] { return state->finished; });
  // An answer that comes too late is none, also when this thread was not run in between.
  if (!state->finished || std::chrono::steady_clock::now() > deadline) {
    return Unreachable(fmt::format(
        "looking up the name {} took too long: the name service does not answer", host));
  }
  return ReadAddresses(host, *state);
}

// Non-blocking and started; the errno when it failed at once.
Result<Descriptor> Start(const Address& address) {
  Descriptor socket(
      ::socket(address.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.open()) return Unreachable(std::generic_category().message(errno));
  const int on = 1;
  setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  int code = 0;
  while ((code = connect(socket.get(), address.get(), address.length)) != 0 && errno == EINTR) {
  }
  if (code != 0 && errno != EINPROGRESS && errno != EALREADY) {
    return Unreachable(base::ToLower(std::generic_category().message(errno)));
  }
  return socket;
}

int SocketError(int descriptor) {
  int error = 0;
  socklen_t length = sizeof error;
  if (getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &length) != 0) return errno;
  return error;
}

// The attempts under way at one time, the eldest first.
class Attempts {
 public:
  void Begin(const Address& address) {
    auto socket = Start(address);
    if (socket) {
      sockets_.push_back(*std::move(socket));
    } else {
      AddCause(socket.error().message);
    }
  }

  [[nodiscard]] bool empty() const { return sockets_.empty(); }
  [[nodiscard]] const std::string& cause() const { return cause_; }

  /// The first that is connected by then; those that failed are gone afterwards.
  Descriptor Await(Deadline deadline) {
    std::vector<pollfd> waiting;
    for (const Descriptor& socket : sockets_) waiting.push_back({socket.get(), POLLOUT, 0});
    if (poll(waiting.data(), waiting.size(), MillisecondsUntil(deadline)) <= 0) return {};
    for (std::size_t i = waiting.size(); i-- > 0;) {
      if (waiting[i].revents == 0) continue;
      const int error = SocketError(waiting[i].fd);
      if (error == 0) return std::move(sockets_[i]);
      AddCause(base::ToLower(std::generic_category().message(error)));
      sockets_.erase(sockets_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return {};
  }

 private:
  void AddCause(std::string cause) {
    if (cause_.empty()) cause_ = std::move(cause);
  }

  std::vector<Descriptor> sockets_;
  std::string cause_;  // of the first that failed
};

}  // namespace

int MillisecondsUntil(Deadline deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
  return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3'600'000));
}

void AcknowledgeAtOnce(int descriptor) {
  const int on = 1;
  setsockopt(descriptor, IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

short WaitFor(int descriptor, short events, Deadline deadline) {
  while (true) {
    pollfd waiting{descriptor, events, 0};
    const int left = MillisecondsUntil(deadline);
    const int ready = poll(&waiting, 1, left);
    if (ready > 0) return waiting.revents;
    if (left == 0) return 0;
  }
}

Result<std::vector<Address>> Lookup(const std::string& host, std::uint16_t port,
                                    Deadline deadline) {
  if (base::EqualsIgnoringCase(host, "localhost")) {
    auto addresses = Lookup("127.0.0.1", port, deadline);
    if (auto v6 = Lookup("::1", port, deadline); addresses && v6) {
      addresses->push_back(v6->front());
    }
    return addresses;
  }
  LookupState numeric;
  RunLookup(numeric, host, port, AI_NUMERICHOST);
  if (numeric.code == 0) return ReadAddresses(host, numeric);
  return LookupOnThread(host, port, deadline);
}

Result<Descriptor> TcpConnect(const std::vector<Address>& addresses, Deadline deadline) {
  Attempts attempts;
  auto next = addresses.begin();
  while (true) {
    if (attempts.empty() && next == addresses.end()) return Unreachable(attempts.cause());
    const Deadline now = steady_clock::now();
    if (now >= deadline) return Unreachable("no answer");
    if (next != addresses.end()) attempts.Begin(*next++);
    if (attempts.empty()) continue;
    // Those that fail wake us early; the rest of the head start is theirs who are still under way.
    const Deadline until =
        next == addresses.end() ? deadline : std::min(deadline, now + kHeadStart);
    if (Descriptor connected = attempts.Await(until); connected.open()) return connected;
  }
}

}  // namespace fleetpub::mqtt
