#include "mqtt/paho/paho_watch.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/text.h"
#include "mqtt/certificate_check.h"

namespace fleetpub::mqtt {
namespace {

thread_local ConnectWatch* current_watch = nullptr;

// Guarded by PahoMutex(), which is held whenever Paho can trace.
int watches = 0;
std::vector<std::function<void(std::string_view)>*> observers;

// After `marker`, or "" when the line has none.
std::string_view After(std::string_view line, std::string_view marker) {
  const std::size_t at = line.find(marker);
  return at == std::string_view::npos ? std::string_view() : line.substr(at + marker.size());
}

// Paho traces nothing that anybody listens to unless told so, and formats every line that its level
// lets through.
void ApplyTraceLevel() {
  MQTTClient_setTraceLevel(watches > 0 || !observers.empty() ? MQTTCLIENT_TRACE_PROTOCOL
                                                             : MQTTCLIENT_TRACE_ERROR);
}

}  // namespace

std::mutex& PahoMutex() {
  static std::mutex mutex;
  return mutex;
}

struct TlsCallbacks {
  // OpenSSL calls this while it makes an SSL: too early to use it, in time to know it.
  static void OnNew(void* parent, void* /*value*/, CRYPTO_EX_DATA* data, int index, long /*argl*/,
                    void* /*argp*/) {
    if (current_watch == nullptr) return;
    current_watch->tls_.ssl_ = static_cast<SSL*>(parent);
    CRYPTO_set_ex_data(data, index, &current_watch->tls_);
    SSL_set_info_callback(static_cast<SSL*>(parent), OnInfo);
  }

  // Paho names the host of the URL, even an address; the first message is made after this. Paho's
  // own callback stands in the context.
  static void OnInfo(const SSL* ssl, int where, int value) {
    if ((where & SSL_CB_HANDSHAKE_START) != 0 && current_watch != nullptr &&
        current_watch->tls_.ssl_ == ssl) {
      std::string& host = current_watch->tls_.host_;
      SSL_ctrl(current_watch->tls_.ssl_, SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name,
               AddressBytes(host).empty() ? host.data() : nullptr);
    }
    const auto pahos = SSL_CTX_get_info_callback(SSL_get_SSL_CTX(ssl));
    if (pahos != nullptr) pahos(ssl, where, value);
  }

  static void OnFree(void* parent, void* value, CRYPTO_EX_DATA* /*data*/, int /*index*/,
                     long /*argl*/, void* /*argp*/) {
    auto* const watch = static_cast<TlsWatch*>(value);
    if (watch != nullptr && watch->ssl_ == parent) watch->ssl_ = nullptr;
  }

  // Likewise while it makes an SSL_CTX, which keeps what is set here: Paho looks at the host name
  // only after the handshake, and would take the subject or a name in place of an address.
  static void OnNewContext(void* parent, void* /*value*/, CRYPTO_EX_DATA* /*data*/, int /*index*/,
                           long /*argl*/, void* /*argp*/) {
    if (current_watch == nullptr || !current_watch->tls_.verify_) return;
    SSL_CTX_set_cert_verify_callback(static_cast<SSL_CTX*>(parent), Verify, &current_watch->tls_);
  }

  static int Verify(X509_STORE_CTX* store, void* watch) {
    CertificateVerdict status = VerifyCertificate(store, static_cast<TlsWatch*>(watch)->host_);
    const bool accepted = status.code == X509_V_OK;
    if (current_watch != nullptr) {
      current_watch->facts_.verify_code = status.code;
      current_watch->facts_.certificate_names = std::move(status.names);
    }
    return accepted ? 1 : 0;
  }

  static void Install() {
    static const int connections = SSL_get_ex_new_index(0, nullptr, OnNew, nullptr, OnFree);
    static const int contexts =
        SSL_CTX_get_ex_new_index(0, nullptr, OnNewContext, nullptr, nullptr);
    static_cast<void>(connections + contexts);
  }
};

struct TraceCallback {
  static void OnLine(enum MQTTCLIENT_TRACE_LEVELS level, char* text) {
    if (text == nullptr || level < MQTTCLIENT_TRACE_PROTOCOL) return;
    const std::string_view line = text;
    if (current_watch != nullptr) Record(*current_watch, line);
    if (!observers.empty() && IsForPeople(line))
      (*observers.back())(base::Printable(WithoutTime(line)));
  }

  static void Record(ConnectWatch& watch, std::string_view line) {
    ConnectFacts& facts = watch.facts_;
    if (!After(line, "-> CONNECT version").empty()) {
      facts.connect_sent = true;
    } else if (const auto alert = After(line, "SSL alert "); !alert.empty()) {
      // "write:fatal:unknown CA"; a close notify is a warning and says nothing.
      if (const auto text = After(alert, "fatal:"); !text.empty()) {
        facts.tls_alert = text;
        facts.alert_is_theirs = alert.starts_with("read");
      }
    } else if (!After(line, "read server certificate request").empty()) {
      facts.wants_certificate = true;
    } else if (const auto status = After(line, "WebSocket HTTP rc "); !status.empty()) {
      facts.http_status = status.substr(0, 3);
      watch.abort_();  // Paho would send CONNECT, with the password, to a server that refused to
                       // speak MQTT
    }
  }

  // Paho prints no user name and no password; a proxy's credentials it would, were it given any.
  static bool IsForPeople(std::string_view line) {
    return line.find("roxy") == std::string_view::npos &&
           line.find("cipher available") == std::string_view::npos;
  }

  // "20260102 030405.678 " stands before every line.
  static std::string_view WithoutTime(std::string_view line) {
    constexpr std::size_t kTime = 20;
    return line.size() > kTime && line[8] == ' ' && line[kTime - 1] == ' ' ? line.substr(kTime)
                                                                           : line;
  }
};

bool TlsWatch::HasBufferedData() const { return ssl_ != nullptr && SSL_pending(ssl_) > 0; }

ConnectWatch::ConnectWatch(TlsWatch& tls, bool trace, std::function<void()> abort)
    : tls_(tls), abort_(std::move(abort)) {
  current_watch = this;
  if (trace) {
    TlsCallbacks::Install();
    MQTTClient_setTraceCallback(TraceCallback::OnLine);
    ++watches;
  }
  ApplyTraceLevel();
}

ConnectWatch::~ConnectWatch() {
  current_watch = nullptr;
  watches = 0;  // one at a time: PahoMutex() is held
  ApplyTraceLevel();
}

int ConnectWatch::OnTlsError(const char* text, std::size_t length, void* watch) {
  auto* const self = static_cast<ConnectWatch*>(watch);
  std::string_view line(text, length);
  while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  ConnectFacts& facts = self->facts_;
  if (!facts.tls_errors.empty()) facts.tls_errors += "; ";
  facts.tls_errors += base::Printable(line);
  return 1;
}

TraceObserver::TraceObserver(std::function<void(std::string_view)> observer)
    : observer_(std::move(observer)) {
  const std::lock_guard lock(PahoMutex());
  observers.push_back(&observer_);
  MQTTClient_setTraceCallback(TraceCallback::OnLine);
  ApplyTraceLevel();
}

TraceObserver::~TraceObserver() {
  const std::lock_guard lock(PahoMutex());
  std::erase(observers, &observer_);
  ApplyTraceLevel();
}

}  // namespace fleetpub::mqtt
