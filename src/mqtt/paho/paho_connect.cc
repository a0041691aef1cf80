#include "mqtt/paho/paho_connect.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include "base/text.h"
#include "base/uuid.h"
#include "mqtt/http_proxy.h"
#include "mqtt/paho/paho_errors.h"
#include "mqtt/paho/paho_sockets.h"
#include "mqtt/tls_files.h"

namespace fleetpub::mqtt {
namespace {

using std::chrono::steady_clock;

// Debian's level for every program that does not choose for itself. Paho chooses 1. From 1 on,
// OpenSSL 3 has no TLS older than 1.2, and Paho has no working option that says so.
constexpr const char* kDefaultCiphers = "DEFAULT@SECLEVEL=2";

void InitializePaho() {
  static std::once_flag once;
  std::call_once(once, [] {
    // OpenSSL has initialized itself since 1.1; Paho's way costs every start 0.35 ms.
    MQTTClient_init_options options = MQTTClient_init_options_initializer;
    options.do_openssl_init = 0;
    MQTTClient_global_init(&options);
  });
  // What Paho would obey: proxies even for plain MQTT, and a trace on standard output.
  for (const char* const name :
       {"http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY", "MQTT_C_CLIENT_TRACE"}) {
    if (getenv(name) != nullptr) unsetenv(name);
  }
}

// What MQTTClient_connectOptions points to.
class Arguments {
 public:
  Arguments(const BrokerUrl& broker, const ConnectOptions& options, ConnectWatch& watch)
      : username_(options.username.empty() ? broker.username : options.username) {
    const bool v5 = options.version == ProtocolVersion::k5;
    MQTTClient_connectOptions v5_options = MQTTClient_connectOptions_initializer5;
    if (v5) paho_ = v5_options;
    paho_.MQTTVersion = v5 ? MQTTVERSION_5 : MQTTVERSION_3_1_1;
    paho_.keepAliveInterval =
        static_cast<int>(std::clamp<std::int64_t>(options.keep_alive.count(), 0, 65'535));
    // Whole seconds; PahoCall knows the exact end. One more, so that it is always the one to speak.
    paho_.connectTimeout =
        static_cast<int>(std::chrono::ceil<std::chrono::seconds>(options.connect_timeout).count()) +
        1;
    paho_.reliable = 0;
    paho_.maxInflightMessages = std::clamp(options.window, 1, 65'535);
    if (!username_.empty()) paho_.username = username_.c_str();
    if (options.password) {
      paho_.binarypwd.data = options.password->data();
      paho_.binarypwd.len = static_cast<int>(options.password->size());
    }
    if (broker.UsesTls()) SetTls(options.tls, watch);
    if (options.will) SetWill(*options.will);
  }

  MQTTClient_connectOptions* get() { return &paho_; }

 private:
  static const char* OrNull(const std::string& text) {
    return text.empty() ? nullptr : text.c_str();
  }

  // Points into the will, which is the caller's.
  void SetWill(const Will& will) {
    will_.topicName = will.topic.c_str();
    will_.payload.data = will.payload.data();
    will_.payload.len = static_cast<int>(will.payload.size());
    will_.qos = static_cast<int>(will.qos);
    will_.retained = will.retain ? 1 : 0;
    paho_.will = &will_;
  }

  void SetTls(const TlsOptions& tls, ConnectWatch& watch) {
    trust_store_ = tls.ca_file.empty() && tls.ca_path.empty() ? FindTrustStore() : tls.ca_file;
    ssl_.trustStore = OrNull(trust_store_);
    ssl_.CApath = OrNull(tls.ca_path);
    ssl_.keyStore = OrNull(tls.cert_file);
    ssl_.privateKey = OrNull(tls.key_file);
    // Never null: OpenSSL would ask for it on the terminal.
    ssl_.privateKeyPassword = tls.key_password ? tls.key_password->c_str() : "";
    ssl_.enabledCipherSuites = tls.ciphers.empty() ? kDefaultCiphers : tls.ciphers.c_str();
    ssl_.enableServerCertAuth = tls.verify ? 1 : 0;
    // Paho's second look, at the host of the URL; ours (certificate_check.h) has been by then.
    ssl_.verify = tls.verify && tls.server_name.empty() ? 1 : 0;
    ssl_.ssl_error_cb = ConnectWatch::OnTlsError;
    ssl_.ssl_error_context = &watch;
    for (const std::string& protocol : tls.alpn) {
      alpn_ += static_cast<char>(protocol.size());
      alpn_ += protocol;
    }
    if (!alpn_.empty()) {
      ssl_.protos = reinterpret_cast<const unsigned char*>(alpn_.data());
      ssl_.protos_len = static_cast<unsigned>(alpn_.size());
    }
    paho_.ssl = &ssl_;
  }

  std::string username_;
  std::string trust_store_;
  std::string alpn_;  // length-prefixed
  MQTTClient_willOptions will_ = MQTTClient_willOptions_initializer;
  MQTTClient_SSLOptions ssl_ = MQTTClient_SSLOptions_initializer;
  MQTTClient_connectOptions paho_ = MQTTClient_connectOptions_initializer;
};

// A URL as Paho takes it apart: it looks for the last colon, so an IPv6 address goes without
// brackets (with them no certificate would ever match) and a path has no colon. For plain MQTT it
// needs the host for nothing but connecting.
std::string PahoUri(const BrokerUrl& broker, const std::string& numeric_host) {
  std::string_view prefix = "tcp://";
  if (broker.scheme == Scheme::kMqtts) prefix = "ssl://";
  if (broker.scheme == Scheme::kWs) prefix = "ws://";
  if (broker.scheme == Scheme::kWss) prefix = "wss://";
  const std::string& host = broker.scheme == Scheme::kMqtt ? numeric_host : broker.host;
  std::string path = broker.path;
  for (std::size_t at = 0; (at = path.find(':', at)) != std::string::npos;) {
    path.replace(at, 1, "%3A");
  }
  return fmt::format("{}{}:{}{}", prefix, host, broker.port, path);
}

std::string NumericHost(const Address& address) {
  std::string host(NI_MAXHOST, '\0');
  if (getnameinfo(address.get(), address.length, host.data(), static_cast<socklen_t>(host.size()),
                  nullptr, 0, NI_NUMERICHOST) != 0) {
    return {};
  }
  host.resize(host.find('\0'));
  return host;
}

struct Route {
  Descriptor connected;  // not open when Paho has to connect for itself
  std::string numeric_host = "127.0.0.1";
};

// Lookup, TCP and the proxy.
Result<Route> FindRoute(const BrokerUrl& broker, const ConnectOptions& options, Deadline deadline,
                        bool& may_heal) {
  HttpProxy proxy;
  if (!options.proxy.empty()) {
    auto parsed = ParseHttpProxy(options.proxy);
    if (!parsed) return Fail(std::move(parsed.error()));
    proxy = *std::move(parsed);
  }
  const bool tunnel = !proxy.host.empty();
  const auto addresses =
      Lookup(tunnel ? proxy.host : broker.host, tunnel ? proxy.port : broker.port, deadline);
  if (!addresses) return Fail(addresses.error());
  Route route;
  if (!PahoCall::Supported()) {
    route.numeric_host = NumericHost(addresses->front());
    return route;
  }
  auto connected = TcpConnect(*addresses, deadline);
  if (!connected) {
    Error error = std::move(connected.error());
    if (tunnel)
      error.message = fmt::format("the proxy {}:{}: {}", proxy.host, proxy.port, error.message);
    return Fail(std::move(error));
  }
  route.connected = *std::move(connected);
  if (tunnel) {
    auto status =
        OpenTunnel(route.connected.get(), proxy, broker.host, broker.port, deadline, may_heal);
    if (!status) return Fail(std::move(status.error()));
  }
  return route;
}

std::string_view GetFirstBytes(const BrokerUrl& broker, ProtocolVersion version) {
  if (broker.UsesTls()) return {};  // OpenSSL reads without asking poll() first, and knows its own
  if (broker.UsesWebSocket()) return "H";                       // TTP/1.1
  return version == ProtocolVersion::k5 ? "\x20\xF0" : "\x20";  // CONNACK, AUTH
}

std::optional<int> NumericProperty(MQTTProperties* properties, enum MQTTPropertyCodes code) {
  if (properties == nullptr || MQTTProperties_hasProperty(properties, code) == 0)
    return std::nullopt;
  return static_cast<int>(MQTTProperties_getNumericValue(properties, code));
}

void ReadProperties(MQTTProperties* properties, PahoConnection& connection) {
  ServerInfo& server = connection.server;
  if (const auto qos = NumericProperty(properties, MQTTPROPERTY_CODE_MAXIMUM_QOS)) {
    server.maximum_qos = static_cast<Qos>(*qos);
  }
  if (const auto retain = NumericProperty(properties, MQTTPROPERTY_CODE_RETAIN_AVAILABLE)) {
    server.retain_available = *retain != 0;
  }
  if (const auto wildcard =
          NumericProperty(properties, MQTTPROPERTY_CODE_WILDCARD_SUBSCRIPTION_AVAILABLE)) {
    server.wildcard_available = *wildcard != 0;
  }
  if (const auto size = NumericProperty(properties, MQTTPROPERTY_CODE_MAXIMUM_PACKET_SIZE)) {
    server.maximum_packet_size = static_cast<std::uint32_t>(*size);
  }
  if (const auto maximum = NumericProperty(properties, MQTTPROPERTY_CODE_RECEIVE_MAXIMUM)) {
    connection.receive_maximum = std::max(*maximum, 1);
  }
  const MQTTProperty* const id =
      properties == nullptr
          ? nullptr
          : MQTTProperties_getProperty(properties, MQTTPROPERTY_CODE_ASSIGNED_CLIENT_IDENTIFER);
  if (id != nullptr) {
    server.assigned_client_id.assign(id->value.data.data,
                                     static_cast<std::size_t>(id->value.data.len));
  }
}

// What CONNECT says on MQTT 5. Paho copies it.
void AddBytes(MQTTProperties& properties, enum MQTTPropertyCodes code, const std::string& bytes) {
  MQTTProperty property{};
  property.identifier = code;
  property.value.data = {static_cast<int>(bytes.size()), const_cast<char*>(bytes.data())};
  MQTTProperties_add(&properties, &property);
}

// Runs Paho's connect; its code, and on success what the broker said of itself.
int RunConnect(MQTTClient client, MQTTClient_connectOptions* options,
               const std::optional<Authentication>& authentication, PahoConnection& connection,
               std::optional<int>& server_keep_alive) {
  if (options->MQTTVersion != MQTTVERSION_5) return MQTTClient_connect(client, options);
  MQTTProperty size{};
  size.identifier = MQTTPROPERTY_CODE_MAXIMUM_PACKET_SIZE;
  size.value.integer4 = kMaximumIncomingPacket;
  MQTTProperties asked = MQTTProperties_initializer;
  MQTTProperties_add(&asked, &size);
  if (authentication) {
    AddBytes(asked, MQTTPROPERTY_CODE_AUTHENTICATION_METHOD, authentication->method);
    if (authentication->data) {
      AddBytes(asked, MQTTPROPERTY_CODE_AUTHENTICATION_DATA, *authentication->data);
    }
  }
  MQTTResponse response = MQTTClient_connect5(client, options, &asked, nullptr);
  MQTTProperties_free(&asked);
  const int code = ReasonCode(response);
  if (code == MQTTCLIENT_SUCCESS) {
    ReadProperties(response.properties, connection);
    server_keep_alive = NumericProperty(response.properties, MQTTPROPERTY_CODE_SERVER_KEEP_ALIVE);
  }
  MQTTResponse_free(response);
  return code;
}

std::string ClientId(const ConnectOptions& options) {
  if (!options.client_id.empty()) return options.client_id;
  // What every broker must take: 23 characters, no others than letters and digits (§3.1.3.1).
  std::string digits = base::RandomUuid();
  std::erase(digits, '-');
  return "fleetpub" + digits.substr(0, 15);
}

using Attempted = tl::expected<PahoConnection, ConnectFailure>;

tl::unexpected<ConnectFailure> Failed(ConnectFailure failure) {
  return tl::unexpected(std::move(failure));
}

// Whether whoever answered may do so otherwise later: it hung up, said nothing, or is too busy.
bool MayHeal(const ConnectFacts& facts, bool lacks_ours) {
  // 3.1.1 §3.2.2.3; MQTT 5 §3.2.2.2: unavailable, busy, shutting down, quota exceeded, connection
  // rate exceeded.
  constexpr std::array<int, 6> kBusy = {3, 0x88, 0x89, 0x8B, 0x97, 0x9F};
  const bool is_refused = facts.code > 0;
  if (is_refused) return std::find(kBusy.begin(), kBusy.end(), facts.code) != kBusy.end();
  if (!facts.http_status.empty()) return IsPassing(facts.http_status);
  // A server that wants a certificate of ours may hang up before its alert can be read (TLS 1.3).
  const bool lacks_certificate = facts.wants_certificate && lacks_ours && !facts.expired;
  return !lacks_certificate && !facts.wrong_first && facts.fault.empty() &&
         facts.verify_code == 0 && facts.tls_alert.empty();
}

Attempted Attempt(const BrokerUrl& broker, const ConnectOptions& options,
                  std::optional<int>& server_keep_alive) {
  const Deadline deadline = steady_clock::now() + options.connect_timeout;
  bool may_heal = true;
  auto route = FindRoute(broker, options, deadline, may_heal);
  if (!route) return Failed({.error = ReachError(broker, route.error()), .may_heal = may_heal});

  const std::lock_guard lock(PahoMutex());
  PahoConnection connection;
  connection.tls = std::make_unique<TlsWatch>(options.tls.FindServerName(broker),
                                              broker.UsesTls() && options.tls.verify);
  connection.server.broker = broker;
  connection.server.site = options.brokers;
  connection.server.version = options.version;
  connection.retain_as_published = options.retain_as_published;

  MQTTClient_createOptions create = MQTTClient_createOptions_initializer;
  create.MQTTVersion = options.version == ProtocolVersion::k5 ? MQTTVERSION_5 : MQTTVERSION_3_1_1;
  MQTTClient client = nullptr;
  int code = MQTTClient_createWithOptions(&client, PahoUri(broker, route->numeric_host).c_str(),
                                          ClientId(options).c_str(), MQTTCLIENT_PERSISTENCE_NONE,
                                          nullptr, &create);
  if (code != MQTTCLIENT_SUCCESS) {
    return Failed(
        {.error = {ErrorKind::kUnexpected, "the MQTT library makes no client: is memory short?",
                   MQTTClient_strerror(code)}});
  }
  PahoCall call(-1, deadline);
  ConnectWatch watch(*connection.tls, broker.UsesTls() || broker.UsesWebSocket(),
                     [&call] { call.Abort(); });
  connection.input = std::make_unique<PahoInput>(
      options.version, broker.UsesWebSocket() ? Framing::kWebSocket : Framing::kNone);
  call.Feed(*connection.input);
  if (route->connected.open()) call.Adopt(std::move(route->connected));
  call.ExpectFirst(GetFirstBytes(broker, options.version));
  Arguments arguments(broker, options, watch);
  code = RunConnect(client, arguments.get(), options.authentication, connection, server_keep_alive);
  if (code == MQTTCLIENT_SUCCESS) {
    connection.client = client;
    connection.descriptor = call.descriptor();
    return connection;
  }
  MQTTClient_destroy(&client);
  ConnectFacts facts = watch.facts();
  facts.code = code;
  facts.expired = call.expired() || steady_clock::now() >= deadline;
  facts.wrong_first = call.wrong_first();
  facts.fault = connection.input->fault();
  facts.wants_more_authentication = connection.input->check().WantsMoreAuthentication();
  facts.reason = connection.input->check().reason();
  if (broker.UsesTls() && !facts.connect_sent) {
    if (auto status = CheckTlsFiles(options.tls); !status) {
      return Failed({.error = std::move(status.error())});
    }
  }
  return Failed({.error = ConnectError(broker, options, facts),
                 .distrusted = facts.verify_code != 0,
                 .may_heal = MayHeal(facts, options.tls.cert_file.empty())});
}

// Whoever disturbs one of the brokers decides which of them is used.
Status CheckSameSecrecy(const std::vector<BrokerUrl>& brokers) {
  const auto uses_tls = [](const BrokerUrl& broker) { return broker.UsesTls(); };
  const auto encrypted = std::find_if(brokers.begin(), brokers.end(), uses_tls);
  const auto plain = std::find_if_not(brokers.begin(), brokers.end(), uses_tls);
  if (encrypted == brokers.end() || plain == brokers.end()) return {};
  return Fail(
      ErrorKind::kUsage,
      fmt::format("{} is encrypted and {} is not: brokers that stand in for each other are all "
                  "mqtts:// (or wss://), or none is, lest a failure lead to plain text",
                  encrypted->ToString(), plain->ToString()));
}

}  // namespace

bool IsMqttString(const std::string& text) {
  return text.size() <= 65'535 && base::IsUtf8(text) && text.find('\0') == std::string::npos;
}

namespace {

Status CheckAuthentication(const ConnectOptions& options) {
  if (!options.authentication) return {};
  const auto& [method, data] = *options.authentication;
  if (method.empty()) {
    return Fail(ErrorKind::kUsage,
                "authentication data without a method: name that with --auth-method");
  }
  if (options.version != ProtocolVersion::k5) {
    return Fail(ErrorKind::kUsage, "--auth-method needs MQTT 5: add --mqtt-version 5");
  }
  if (!IsMqttString(method)) {
    return Fail(ErrorKind::kUsage,
                "--auth-method is no MQTT text: UTF-8 without NUL, 65,535 bytes at most");
  }
  if (data && data->size() > 65'535) {
    return Fail(ErrorKind::kUsage,
                "--auth-data-file holds more than the 65,535 bytes that MQTT can carry");
  }
  return {};
}

}  // namespace

Status CheckConnectOptions(const ConnectOptions& options) {
  if (options.brokers.empty())
    return Fail(ErrorKind::kUsage, "no broker is given: use --broker mqtt://host");
  if (auto status = CheckSameSecrecy(options.brokers); !status) return status;
  if (!IsMqttString(options.client_id) || !IsMqttString(options.username)) {
    return Fail(
        ErrorKind::kUsage,
        "the client id or the user name is no MQTT text: UTF-8 without NUL, 65,535 bytes at most");
  }
  if (options.password && options.password->size() > 65'535) {
    return Fail(ErrorKind::kUsage,
                "the password is longer than 65,535 bytes, the most that MQTT can carry");
  }
  if (auto status = CheckAuthentication(options); !status) return status;
  const bool named = !options.username.empty() ||
                     std::all_of(options.brokers.begin(), options.brokers.end(),
                                 [](const BrokerUrl& broker) { return !broker.username.empty(); });
  if (options.password && !named && options.version == ProtocolVersion::k311) {
    return Fail(ErrorKind::kUsage,
                "a password without a user name (MQTT 3.1.1 has no such thing): give --username");
  }
  if (!options.proxy.empty()) {
    if (!PahoCall::Supported()) {
      return Fail(
          ErrorKind::kUsage,
          "this build cannot use a proxy (FLEETPUB_FAST_CONNECT is off): leave out --proxy");
    }
    if (auto proxy = ParseHttpProxy(options.proxy); !proxy) return Fail(std::move(proxy.error()));
  }
  if (options.will && (options.will->topic.empty() || !IsMqttString(options.will->topic) ||
                       options.will->payload.size() > 65'535)) {
    return Fail(ErrorKind::kUsage,
                "the last will has no MQTT topic, or more than the 65,535 bytes that MQTT carries");
  }
  const TlsOptions& tls = options.tls;
  if (tls.cert_file.empty() && !tls.key_file.empty()) {
    return Fail(ErrorKind::kUsage,
                "--key without --cert: a private key is of use only with its certificate");
  }
  if (tls.ciphers.find("SECLEVEL=0") != std::string::npos) {
    return Fail(ErrorKind::kUsage,
                "--ciphers asks for SECLEVEL=0, which would let in TLS 1.0: take 1 or higher");
  }
  for (const std::string& protocol : tls.alpn) {
    if (protocol.empty() || protocol.size() > 255) {
      return Fail(ErrorKind::kUsage, "--tls-alpn: a protocol name has 1 to 255 bytes");
    }
  }
  return {};
}

Attempted ConnectTo(const BrokerUrl& broker, const ConnectOptions& options) {
  InitializePaho();
  std::optional<int> server_keep_alive;
  auto connection = Attempt(broker, options, server_keep_alive);
  if (!connection || !server_keep_alive || *server_keep_alive == 0 ||
      (options.keep_alive.count() != 0 && *server_keep_alive >= options.keep_alive.count())) {
    return connection;
  }
  // The broker's keep alive is the one that counts (MQTT 5 §3.2.2.3.14), and Paho cannot change it
  // any more.
  {
    const std::lock_guard lock(PahoMutex());
    const PahoCall call(connection->descriptor, steady_clock::now() + options.connect_timeout);
    MQTTClient_disconnect(connection->client, 0);
    MQTTClient_destroy(&connection->client);
    connection->input.reset();
  }
  ConnectOptions shorter = options;
  shorter.keep_alive = std::chrono::seconds(*server_keep_alive);
  return Attempt(broker, shorter, server_keep_alive);
}

}  // namespace fleetpub::mqtt
