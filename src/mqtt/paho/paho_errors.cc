#include "mqtt/paho/paho_errors.h"

#include <fmt/format.h>
#include <openssl/x509.h>
#include <openssl/x509_vfy.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "base/time.h"
#include "mqtt/http_proxy.h"

namespace fleetpub::mqtt {
namespace {

struct CodeText {
  int code;
  std::string_view text;
};

// MQTT 5 §2.4, those that refuse.
constexpr std::array<CodeText, 35> kReasons{{
    {0x80, "unspecified error"},
    {0x81, "malformed packet"},
    {0x82, "protocol error"},
    {0x83, "implementation specific error"},
    {0x84, "unsupported protocol version"},
    {0x85, "client identifier not valid"},
    {0x86, "bad user name or password"},
    {0x87, "not authorized"},
    {0x88, "server unavailable"},
    {0x89, "server busy"},
    {0x8A, "banned"},
    {0x8B, "server shutting down"},
    {0x8C, "bad authentication method"},
    {0x8D, "keep alive timeout"},
    {0x8E, "session taken over"},
    {0x8F, "topic filter invalid"},
    {0x90, "topic name invalid"},
    {0x91, "packet identifier in use"},
    {0x92, "packet identifier not found"},
    {0x93, "receive maximum exceeded"},
    {0x94, "topic alias invalid"},
    {0x95, "packet too large"},
    {0x96, "message rate too high"},
    {0x97, "quota exceeded"},
    {0x98, "administrative action"},
    {0x99, "payload format invalid"},
    {0x9A, "retain not supported"},
    {0x9B, "QoS not supported"},
    {0x9C, "use another server"},
    {0x9D, "server moved"},
    {0x9E, "shared subscriptions not supported"},
    {0x9F, "connection rate exceeded"},
    {0xA0, "maximum connect time"},
    {0xA1, "subscription identifiers not supported"},
    {0xA2, "wildcard subscriptions not supported"},
}};

// What a person can do about a refused CONNECT. Codes of 3.1.1 §3.2.2.3 and of MQTT 5 §3.2.2.2 side
// by side.
constexpr std::array<CodeText, 20> kRefusals{{
    {1, "it does not speak this version of MQTT: try the other one with -V"},
    {2, "it does not accept this client id: choose another one with --client-id"},
    {3, "the MQTT service is unavailable: try again later"},
    {4, "bad user name or password: check --username and --password-file"},
    {5,
     "not authorized: check --username and --password-file, and what the broker allows this "
     "client"},
    {0x84, "it does not speak this version of MQTT: try the other one with -V"},
    {0x85, "it does not accept this client id: choose another one with --client-id"},
    {0x86, "bad user name or password: check --username and --password-file"},
    {0x87,
     "not authorized: check --username and --password-file, and what the broker allows this "
     "client"},
    {0x88, "the MQTT service is unavailable: try again later"},
    {0x89, "the broker is busy: try again later"},
    {0x8A, "this client is banned: ask the broker's administrator"},
    {0x8B, "it is shutting down: try again later"},
    {0x8C, "it wants a method of authentication: name it with --auth-method, on MQTT 5"},
    {0x97, "quota exceeded (0x97): ask the broker's administrator"},
    {0x9A, "it takes no retained last will"},
    {0x9B, "it takes no last will at this QoS"},
    {0x9C, "it wants this client to use another server: name that one with --broker"},
    {0x9D, "it has moved for good: name the new server with --broker"},
    {0x9F, "too many connections in a short time: try again later"},
}};

// Where a method was used, that is what to look at.
constexpr std::array<CodeText, 3> kMethodRefusals{{
    {0x86, "it does not accept this login: check --auth-data-file and --username"},
    {0x87,
     "not authorized: check --auth-method and --auth-data-file, and what the broker allows this "
     "client"},
    {0x8C, "bad authentication method: check --auth-method"},
}};

// Causes from before MQTT, by how their text begins.
struct Hint {
  std::string_view cause;
  std::string_view hint;
};
constexpr std::array<Hint, 6> kReachHints{{
    {"connection refused", "is a broker running there? (--broker, --host, --port)"},
    {"no answer",
     "is the address right, and does a firewall let it through? (--broker, --connect-timeout)"},
    {"the name", "check the host name (--broker, --host)"},
    {"looking up", "check the network, or give the address in numbers"},
    {"network is unreachable", "is this machine connected to the broker's network?"},
    {"no route to host", "is this machine connected to the broker's network?"},
}};

std::string_view Find(const auto& table, int code) {
  for (const CodeText& entry : table) {
    if (entry.code == code) return entry.text;
  }
  return {};
}

std::string Added(const Reason& reason) {
  std::string added;
  if (!reason.text.empty()) added += fmt::format(", '{}'", base::Printable(reason.text));
  if (!reason.server.empty()) {
    added += fmt::format("; it names the server {}", base::Printable(reason.server));
  }
  return added;
}

Error Broker(std::string message, std::string detail = {}) {
  return {ErrorKind::kBroker, std::move(message), std::move(detail)};
}

std::string WrongNameCause(const ConnectFacts& facts, const std::string& host) {
  const std::string names =
      facts.certificate_names.empty() ? "another host" : base::Printable(facts.certificate_names);
  if (facts.verify_code == X509_V_ERR_IP_ADDRESS_MISMATCH) {
    return fmt::format(
        "its certificate is for {}, not for the address {}, which it must contain as an address "
        "(IP:{}): write the host name in --broker, or name the server with --tls-server-name",
        names, host, host);
  }
  return fmt::format(
      "its certificate is for {}, not for {}: check the host name in --broker, "
      "or name the server with --tls-server-name",
      names, host);
}

std::string VerifyCause(const ConnectFacts& facts, const std::string& host) {
  switch (facts.verify_code) {
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return WrongNameCause(facts, host);
    case X509_V_ERR_INVALID_PURPOSE:
      return "its certificate was not made for a server (its purposes lack serverAuth): the "
             "broker needs one that was";
    case X509_V_ERR_INVALID_CA:
    case X509_V_ERR_PATH_LENGTH_EXCEEDED:
      return "its certificate is signed by somebody who may sign none: do not trust it, and ask "
             "who made it";
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return "its certificate has expired: the broker needs a new one";
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return "its certificate is not yet valid: is this machine's clock right?";
    case X509_V_ERR_CERT_REVOKED:
      return "its certificate has been revoked";
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
      return "its certificate is self-signed and not trusted here: if it is the right one, name it "
             "with --cafile";
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
      return "its certificate is from an authority that is not trusted here: name that authority's "
             "certificate with "
             "--cafile";
    default:
      return fmt::format("its certificate is not accepted (OpenSSL's verdict {}): -v tells more",
                         facts.verify_code);
  }
}

// What the other side is, going by the first byte of its answer.
std::string PeerCause(unsigned char first) {
  const bool tls_record = first == 0x15 || first == 0x16;  // RFC 8446 §5.1: alert, handshake
  if (tls_record) return "what answers there speaks TLS: write mqtts:// (or wss://)";
  if (first == 'H')
    return "what answers there speaks HTTP, not MQTT: write ws://, or check the port";
  return "what answers there is not an MQTT broker: check the port";
}

// What a server says to a client's certificate, or to none (RFC 8446 §6.2, RFC 5246 §7.4.6).
bool IsAboutOurCertificate(const ConnectFacts& facts) {
  constexpr std::array<std::string_view, 5> kAlerts{"certificate", "unknown CA", "access denied",
                                                    "decrypt error", "handshake failure"};
  return facts.wants_certificate && facts.alert_is_theirs &&
         std::any_of(kAlerts.begin(), kAlerts.end(), [&](std::string_view alert) {
           return facts.tls_alert.find(alert) != std::string::npos;
         });
}

std::string OurCertificateCause(const ConnectFacts& facts, const ConnectOptions& options) {
  if (options.tls.cert_file.empty()) {
    return "it asks for a certificate of ours: give --cert and --key";
  }
  return fmt::format(
      "it does not accept our certificate{}: is --cert the one that the broker's administrator "
      "gave out, and still valid?",
      facts.tls_alert.empty() ? "" : fmt::format(" ({})", base::Printable(facts.tls_alert)));
}

std::string TlsCause(const ConnectFacts& facts, const ConnectOptions& options) {
  if (IsAboutOurCertificate(facts)) return OurCertificateCause(facts, options);
  if (facts.tls_errors.find("wrong version number") != std::string::npos) {
    return "what answers there does not speak TLS: is it the port without TLS? (mqtt:// instead of "
           "mqtts://)";
  }
  if (facts.tls_errors.find("no protocols available") != std::string::npos ||
      facts.tls_errors.find("unsupported protocol") != std::string::npos ||
      facts.tls_alert.find("protocol version") != std::string::npos) {
    return "it offers no TLS from 1.2 on, which is the oldest that is safe";
  }
  if (!facts.tls_alert.empty()) {
    return fmt::format("the TLS handshake failed with the alert '{}'",
                       base::Printable(facts.tls_alert));
  }
  return "it closed the connection during the TLS handshake: does it speak TLS on this port? "
         "(otherwise mqtt:// instead of mqtts://)";
}

// 3.1.1 has no word for most of what a broker can have against a client (§3.2.2.3).
std::string HungUpCause(const BrokerUrl& broker, const ConnectOptions& options) {
  std::string causes;
  if (options.version == ProtocolVersion::k311) {
    causes = options.will ? "the last will, " : "";
    causes += "the client id, one connection too many, ";
  }
  return fmt::format(
      "it closed the connection without an answer: does it refuse {}this version of MQTT (-V{}){}?",
      causes, options.version == ProtocolVersion::k5 ? "" : " 5 may tell the reason",
      broker.UsesTls() ? "" : ", or is it a port for TLS (mqtts://)");
}

std::string Cause(const BrokerUrl& broker, const ConnectOptions& options,
                  const ConnectFacts& facts) {
  if (facts.wrong_first) return PeerCause(*facts.wrong_first);
  if (facts.wants_more_authentication && options.authentication) {
    return "it asks for a further step of the authentication (AUTH), and fleetpub takes one: "
           "choose "
           "a method of one step with --auth-method";
  }
  if (!facts.fault.empty()) {
    return fmt::format(
        "it sent {}: is it a sound MQTT broker, and does it speak this version of MQTT (-V)?",
        facts.fault);
  }
  if (facts.verify_code != 0) return VerifyCause(facts, options.tls.FindServerName(broker));
  if (!facts.http_status.empty()) {
    return fmt::format("it refuses the WebSocket (HTTP status {}): {}",
                       base::Printable(facts.http_status),
                       IsPassing(facts.http_status) ? "is the broker behind it running?"
                                                    : "check the path in the URL");
  }
  if (facts.expired) {
    return fmt::format(
        "something listens there but gave no {} answer within {}: is it a broker? "
        "(--connect-timeout)",
        broker.UsesTls() && !facts.connect_sent ? "TLS" : "MQTT",
        base::FormatElapsed(options.connect_timeout));
  }
  if (broker.UsesTls() && (!facts.tls_errors.empty() || !facts.connect_sent)) {
    return TlsCause(facts, options);
  }
  // In TLS 1.3 the server looks at our certificate when we have spoken already, and mosquitto hangs
  // up before its alert could be read.
  if (facts.wants_certificate) return OurCertificateCause(facts, options);
  return HungUpCause(broker, options);
}

}  // namespace

std::string ReasonText(int reason_code, const Reason& added) {
  const std::string_view text = Find(kReasons, reason_code);
  return fmt::format("{} (0x{:02X}){}", text.empty() ? "unknown reason" : text, reason_code,
                     Added(added));
}

Error ReachError(const BrokerUrl& broker, const Error& cause) {
  std::string message = fmt::format("cannot reach {}: {}", broker.ToString(), cause.message);
  for (const Hint& entry : kReachHints) {
    if (cause.message.starts_with(entry.cause)) {
      message += fmt::format(": {}", entry.hint);
      break;
    }
  }
  return Broker(std::move(message), cause.detail);
}

Error ConnectError(const BrokerUrl& broker, const ConnectOptions& options,
                   const ConnectFacts& facts) {
  if (facts.code > 0) {
    std::string_view refusal = options.authentication ? Find(kMethodRefusals, facts.code) : "";
    if (refusal.empty()) refusal = Find(kRefusals, facts.code);
    const std::string code =
        facts.code >= 0x80 ? ReasonText(facts.code, {}) : fmt::format("return code {}", facts.code);
    const bool is_about_login = refusal.find("--password-file") != std::string_view::npos ||
                                refusal.find("--auth-") != std::string_view::npos;
    const std::string tried =
        is_about_login && !options.login.empty() ? fmt::format(" (tried: {})", options.login) : "";
    return Broker(fmt::format("{} refused the connection: {}{}{}", broker.ToString(),
                              refusal.empty() ? code : refusal, Added(facts.reason), tried),
                  fmt::format("CONNACK {}", code));
  }
  std::string detail = fmt::format("Paho: {}", facts.code);
  if (!facts.tls_errors.empty()) detail += "; " + facts.tls_errors;
  if (facts.verify_code != 0) {
    detail += fmt::format("; {}", X509_verify_cert_error_string(facts.verify_code));
  }
  return Broker(
      fmt::format("cannot connect to {}: {}", broker.ToString(), Cause(broker, options, facts)),
      std::move(detail));
}

}  // namespace fleetpub::mqtt
