#include "mqtt/paho_watch.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/text.h"

namespace fleetpub::mqtt {
namespace {

thread_local ConnectWatch* current_watch = nullptr;

// Guarded by PahoMutex(), which is held whenever Paho can trace.
int watches = 0;
std::vector<std::function<void(std::string_view)>*> listeners;

// The DNS names of a certificate, as in `a.example, *.b.example`.
std::string NamesOf(const SSL* ssl) {
  if (ssl == nullptr) return {};
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(SSL_get1_peer_certificate(ssl),
                                                                X509_free);
  if (certificate == nullptr) return {};
  const std::unique_ptr<GENERAL_NAMES, decltype(&GENERAL_NAMES_free)> names(
      static_cast<GENERAL_NAMES*>(
          X509_get_ext_d2i(certificate.get(), NID_subject_alt_name, nullptr, nullptr)),
      GENERAL_NAMES_free);
  std::vector<std::string> found;
  for (int i = 0; names != nullptr && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type != GEN_DNS || found.size() == 5) continue;
    found.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(name->d.dNSName)),
                       static_cast<std::size_t>(ASN1_STRING_length(name->d.dNSName)));
  }
  return base::Join(found, ", ");
}

// After `marker`, or "" when the line has none.
std::string_view After(std::string_view line, std::string_view marker) {
  const std::size_t at = line.find(marker);
  return at == std::string_view::npos ? std::string_view() : line.substr(at + marker.size());
}

// Paho traces nothing that anybody listens to unless told so, and formats every line that its level
// lets through.
void ApplyTraceLevel() {
  MQTTClient_setTraceLevel(watches > 0 || !listeners.empty() ? MQTTCLIENT_TRACE_PROTOCOL
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
  }

  static void OnFree(void* parent, void* value, CRYPTO_EX_DATA* /*data*/, int /*index*/,
                     long /*argl*/, void* /*argp*/) {
    auto* const watch = static_cast<TlsWatch*>(value);
    if (watch != nullptr && watch->ssl_ == parent) watch->ssl_ = nullptr;
  }

  static void Install() {
    static const int index = SSL_get_ex_new_index(0, nullptr, OnNew, nullptr, OnFree);
    static_cast<void>(index);
  }
};

struct TraceCallback {
  static void OnLine(enum MQTTCLIENT_TRACE_LEVELS level, char* text) {
    if (text == nullptr || level < MQTTCLIENT_TRACE_PROTOCOL) return;
    const std::string_view line = text;
    if (current_watch != nullptr) Note(*current_watch, line);
    if (!listeners.empty() && IsForPeople(line))
      (*listeners.back())(base::Printable(WithoutTime(line)));
  }

  static void Note(ConnectWatch& watch, std::string_view line) {
    ConnectFacts& facts = watch.facts_;
    if (!After(line, "-> CONNECT version").empty()) {
      facts.connect_sent = true;
      facts.wrong_name = false;
    } else if (const auto alert = After(line, "SSL alert "); !alert.empty()) {
      // "write:fatal:unknown CA"; a close notify is a warning and says nothing.
      if (const auto text = After(alert, "fatal:"); !text.empty()) {
        facts.tls_alert = text;
        facts.alert_is_theirs = alert.starts_with("read");
      }
    } else if (!After(line, "read server certificate request").empty()) {
      facts.wants_certificate = true;
    } else if (!After(line, "X509_check_host for hostname").empty()) {
      facts.wrong_name = true;  // unless it is a host in numbers and CONNECT follows
      facts.certificate_names = NamesOf(watch.tls_.ssl());
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
  if (self->tls_.ssl() != nullptr) facts.verify_code = SSL_get_verify_result(self->tls_.ssl());
  return 1;
}

TraceListener::TraceListener(std::function<void(std::string_view)> listener)
    : listener_(std::move(listener)) {
  const std::lock_guard lock(PahoMutex());
  listeners.push_back(&listener_);
  MQTTClient_setTraceCallback(TraceCallback::OnLine);
  ApplyTraceLevel();
}

TraceListener::~TraceListener() {
  const std::lock_guard lock(PahoMutex());
  std::erase(listeners, &listener_);
  ApplyTraceLevel();
}

}  // namespace fleetpub::mqtt
