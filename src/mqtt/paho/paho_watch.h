// Looking over Paho's shoulder: its trace, and the TLS connection that it makes.
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "mqtt/paho/paho_errors.h"

struct ssl_st;

namespace fleetpub::mqtt {

/// Paho's state is the whole process's and not safe to use from two threads at once: held around
/// every call into it, never while waiting for the network except in connecting and subscribing.
[[nodiscard]] std::mutex& PahoMutex();

/// The TLS connection that Paho makes while a ConnectWatch lives, seen through OpenSSL's ex_data
/// callbacks, since Paho hands out neither the SSL nor what went wrong with it. Lives longer than
/// the connection.
class TlsWatch {
 public:
  /// The broker is told this name as the one that is asked for (RFC 6066 §3: no address), and its
  /// certificate must be for it when `verify`.
  TlsWatch(std::string host, bool verify) : host_(std::move(host)), verify_(verify) {}
  TlsWatch(const TlsWatch&) = delete;
  TlsWatch& operator=(const TlsWatch&) = delete;
  ~TlsWatch() = default;

  /// OpenSSL has bytes that poll() does not know of.
  [[nodiscard]] bool HasBufferedData() const;

 private:
  friend struct TlsCallbacks;
  std::string host_;
  bool verify_;
  ssl_st* ssl_ = nullptr;
};

/// Collects the facts of one connection attempt of this thread.
class ConnectWatch {
 public:
  /// `abort` is called when it is clear that nothing can come of it. Trace lines are read only when
  /// `trace`.
  ConnectWatch(TlsWatch& tls, bool trace, std::function<void()> abort);
  ConnectWatch(const ConnectWatch&) = delete;
  ConnectWatch& operator=(const ConnectWatch&) = delete;
  ~ConnectWatch();

  [[nodiscard]] ConnectFacts& facts() { return facts_; }

  /// For MQTTClient_SSLOptions::ssl_error_cb, with this object as its context.
  static int OnTlsError(const char* text, std::size_t length, void* watch);

 private:
  friend struct TlsCallbacks;
  friend struct TraceCallback;
  TlsWatch& tls_;
  std::function<void()> abort_;
  ConnectFacts facts_;
};

/// Where Paho's protocol steps go, for as long as this lives; the youngest of several gets them.
class TraceObserver {
 public:
  explicit TraceObserver(std::function<void(std::string_view)> observer);
  TraceObserver(const TraceObserver&) = delete;
  TraceObserver& operator=(const TraceObserver&) = delete;
  ~TraceObserver();

 private:
  std::function<void(std::string_view)> observer_;
};

}  // namespace fleetpub::mqtt
