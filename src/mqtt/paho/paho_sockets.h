// Paho's system calls, for as long as one of these lives on the calling thread. See
// paho_sockets.cc.
#pragma once

#include <chrono>
#include <optional>

#include "mqtt/descriptor.h"
#include "mqtt/tcp_connect.h"

namespace fleetpub::mqtt {

class PahoInput;

/// One call into Paho. Belongs to the thread that made it; scopes on one thread do not overlap.
class PahoCall {
 public:
  /// A call on a connection that exists. At the deadline the connection is shut down, which is the
  /// only way to make every one of Paho's waits end.
  PahoCall(int descriptor, Deadline deadline);
  PahoCall(const PahoCall&) = delete;
  PahoCall& operator=(const PahoCall&) = delete;
  ~PahoCall();

  /// Whether the calling thread is inside one.
  [[nodiscard]] static bool IsInside();

  /// Paho's next connection has this input, which outlives the call.
  void Feed(PahoInput& input) { input_ = &input; }
  /// Called by connect().
  static void Connecting(int descriptor);

  /// The next connect() of Paho gets this connected socket instead of making its own connection.
  void Adopt(Descriptor connected) { adopted_ = std::move(connected); }

  /// The bytes with which the peer's first answer may begin; whatever begins otherwise is shut down
  /// before Paho reads (and waits for the rest of) a packet that is none. "" for any.
  void ExpectFirst(std::string_view bytes) { expected_ = bytes; }

  /// The deadline runs anew with whatever the broker sends, until `latest`: on a slow line an answer
  /// comes behind much else.
  void RenewWith(std::chrono::steady_clock::duration patience, Deadline latest) {
    patience_ = patience;
    latest_ = latest;
  }

  /// Lets Paho look for a packet once even when the socket has nothing to read: what OpenSSL or its
  /// WebSocket layer has read ahead is invisible to poll().
  void Probe() { probe_ = true; }

  /// Ends whatever Paho is doing.
  void Abort();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] bool expired() const { return expired_; }
  /// The socket had something to read, be it the end.
  [[nodiscard]] bool readable() const { return readable_; }
  /// The first byte of the peer's answer when it was an unexpected one.
  [[nodiscard]] std::optional<unsigned char> wrong_first() const { return wrong_first_; }

  /// Whether this build takes part in Paho's system calls at all (FLEETPUB_FAST_CONNECT).
  [[nodiscard]] static bool Supported();

 private:
  friend struct Interposed;

  int descriptor_;
  Deadline deadline_;
  std::chrono::steady_clock::duration patience_{0};  // 0: the deadline stays
  Deadline latest_;
  Descriptor adopted_;
  PahoInput* input_ = nullptr;
  std::string_view expected_;
  bool just_connected_ = false;
  bool probe_ = false;
  bool expired_ = false;
  bool readable_ = false;
  std::optional<unsigned char> wrong_first_;
};

}  // namespace fleetpub::mqtt
