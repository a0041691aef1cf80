// A listener that does not behave like a broker.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace fleetpub::testing {

/// Runs the same thing on every connection that it accepts, each on a thread of its own; ends them
/// all with itself.
class BrokenBroker {
 public:
  /// Gets the connected, blocking socket, which is closed after it. Once stopped, reading ends.
  using Behaviour = std::function<void(int socket)>;

  explicit BrokenBroker(Behaviour behaviour);
  BrokenBroker(const BrokenBroker&) = delete;
  BrokenBroker& operator=(const BrokenBroker&) = delete;
  ~BrokenBroker();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::string Url(std::string_view scheme = "mqtt") const;

  /// Accepts, listens, says nothing.
  [[nodiscard]] static Behaviour Silent();
  [[nodiscard]] static Behaviour ClosesAtOnce();
  /// Says this before it is spoken to, then is silent.
  [[nodiscard]] static Behaviour Greets(std::string bytes);
  /// Says the first after the first packet, the second after the second…, then is silent.
  [[nodiscard]] static Behaviour Answers(std::vector<std::string> answers);
  /// `Answers`, then closes.
  [[nodiscard]] static Behaviour AnswersAndCloses(std::vector<std::string> answers);
  /// CONNACK of MQTT 3.1.1.
  [[nodiscard]] static std::string Connack(int code);
  [[nodiscard]] static std::string Connack5(int code);

 private:
  void Accept();

  Behaviour behaviour_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::mutex mutex_;
  std::vector<int> sockets_;
  std::vector<std::thread> threads_;
  std::thread acceptor_;
};

/// What arrives next; "" at the end.
[[nodiscard]] std::string ReadSome(int socket);
/// All of it. False: nobody takes it any more.
bool WriteTo(int socket, std::string_view bytes);

}  // namespace fleetpub::testing
