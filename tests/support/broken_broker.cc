#include "support/broken_broker.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace fleetpub::testing {
namespace {

void ReadToTheEnd(int socket) {
  while (!ReadSome(socket).empty()) {
  }
}

}  // namespace

std::string ReadSome(int socket) {
  std::array<char, 65'536> block;
  const ssize_t got = recv(socket, block.data(), block.size(), 0);
  return got <= 0 ? std::string() : std::string(block.data(), static_cast<std::size_t>(got));
}

bool WriteTo(int socket, std::string_view bytes) {
  return send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

BrokenBroker::BrokenBroker(Behaviour behaviour) : behaviour_(std::move(behaviour)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listener_ < 0 || bind(listener_, generic, length) != 0 || listen(listener_, 64) != 0 ||
      getsockname(listener_, generic, &length) != 0) {
    throw std::system_error(errno, std::generic_category(), "no listener");
  }
  port_ = ntohs(address.sin_port);
  acceptor_ = std::thread([this] { Accept(); });
}

BrokenBroker::~BrokenBroker() {
  shutdown(listener_, SHUT_RDWR);
  acceptor_.join();
  {
    const std::lock_guard lock(mutex_);
    for (const int socket : sockets_) shutdown(socket, SHUT_RDWR);
  }
  for (std::thread& thread : threads_) thread.join();
  for (const int socket : sockets_) close(socket);
  close(listener_);
}

void BrokenBroker::Accept() {
  while (true) {
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) return;
    const std::lock_guard lock(mutex_);
    sockets_.push_back(socket);
    threads_.emplace_back([this, socket] {
      behaviour_(socket);
      // Closed by the destructor only: until then its number must not become another socket's.
      shutdown(socket, SHUT_RDWR);
    });
  }
}

std::string BrokenBroker::Url(std::string_view scheme) const {
  return std::string(scheme) + "://127.0.0.1:" + std::to_string(port_);
}

BrokenBroker::Behaviour BrokenBroker::Silent() { return ReadToTheEnd; }

BrokenBroker::Behaviour BrokenBroker::ClosesAtOnce() {
  return [](int /*socket*/) {};
}

BrokenBroker::Behaviour BrokenBroker::Greets(std::string bytes) {
  return [bytes = std::move(bytes)](int socket) {
    WriteTo(socket, bytes);
    ReadToTheEnd(socket);
  };
}

BrokenBroker::Behaviour BrokenBroker::Answers(std::vector<std::string> answers) {
  return [answers = std::move(answers)](int socket) {
    AnswersAndCloses(answers)(socket);
    ReadToTheEnd(socket);
  };
}

BrokenBroker::Behaviour BrokenBroker::AnswersAndCloses(std::vector<std::string> answers) {
  return [answers = std::move(answers)](int socket) {
    for (const std::string& answer : answers) {
      if (ReadSome(socket).empty()) return;
      WriteTo(socket, answer);
    }
  };
}

std::string BrokenBroker::Connack(int code) {
  return std::string("\x20\x02\x00", 3) + static_cast<char>(code);
}

std::string BrokenBroker::Connack5(int code) {
  return std::string("\x20\x03\x00", 3) + static_cast<char>(code) + std::string(1, '\0');
}

}  // namespace fleetpub::testing
