#include "mqtt/http_proxy.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

#include "base/text.h"
#include "mqtt/broker_url.h"

namespace fleetpub::mqtt {
namespace {

constexpr std::size_t kMaximumAnswer = 16'384;
constexpr std::uint16_t kDefaultPort = 3128;  // squid's, and curl's would be 1080, which is SOCKS

tl::unexpected<Error> BadProxy() {
  return Fail(ErrorKind::kUsage,
              "the proxy is not an HTTP proxy URL: write http://host:port, or in FLEETPUB_PROXY "
              "http://user:password@host:port with @, : and % in them as %40, %3A and %25");
}

tl::unexpected<Error> ProxyFailed(std::string cause) {
  return Fail(ErrorKind::kBroker, std::move(cause));
}

std::string Base64(const std::string& text) {
  std::string encoded((text.size() + 2) / 3 * 4 + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(encoded.data()),
                                     reinterpret_cast<const unsigned char*>(text.data()),
                                     static_cast<int>(text.size()));
  encoded.resize(static_cast<std::size_t>(length));
  return encoded;
}

// A part of the credentials, decoded by the same rules as the user name of a broker URL.
Result<std::string> Decode(std::string_view text) {
  if (text.empty()) return std::string();
  auto url = ParseBrokerUrl(fmt::format("mqtt://{}@x", text));
  if (!url) return BadProxy();
  return std::move(url->username);
}

Result<char> ReadByte(int descriptor, Deadline deadline) {
  while (true) {
    char byte = 0;
    const ssize_t got = recv(descriptor, &byte, 1, 0);
    if (got == 1) return byte;
    if (got == 0) return ProxyFailed("the proxy closed the connection");
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
      return ProxyFailed("the proxy broke the connection");
    }
    if (WaitFor(descriptor, POLLIN, deadline) == 0) return ProxyFailed("the proxy gives no answer");
  }
}

Result<std::string> ReadAnswer(int descriptor, Deadline deadline) {
  std::string answer;
  while (!answer.ends_with("\r\n\r\n")) {
    const auto byte = ReadByte(descriptor, deadline);
    if (!byte) return Fail(byte.error());
    answer += *byte;
    if (answer.size() > kMaximumAnswer) return ProxyFailed("the proxy's answer has no end");
  }
  return answer;
}

}  // namespace

Result<HttpProxy> ParseHttpProxy(std::string_view text) {
  constexpr std::string_view kScheme = "http://";
  if (!base::ToLower(text).starts_with(kScheme)) return BadProxy();
  std::string_view rest = text.substr(kScheme.size());
  HttpProxy proxy;
  if (const std::size_t at = rest.rfind('@'); at != std::string_view::npos) {
    const std::string_view credentials = rest.substr(0, at);
    const std::size_t colon = credentials.find(':');
    const auto user = Decode(credentials.substr(0, colon));
    const auto password =
        Decode(colon == std::string_view::npos ? "" : credentials.substr(colon + 1));
    if (!user || !password || user->empty()) return BadProxy();
    proxy.credentials = *user + ":" + *password;
    rest = rest.substr(at + 1);
  }
  while (rest.ends_with('/')) rest.remove_suffix(1);
  auto url = ParseBrokerUrl(fmt::format("mqtt://{}", rest));
  if (!url) return BadProxy();
  proxy.host = std::move(url->host);
  const bool has_port = rest.rfind(':') != std::string_view::npos && !rest.ends_with(']');
  proxy.port = has_port ? url->port : kDefaultPort;
  return proxy;
}

bool IsPassing(std::string_view http_status) {
  return http_status.starts_with('5') || http_status == "408" || http_status == "429";
}

Status OpenTunnel(int descriptor, const HttpProxy& proxy, const std::string& host,
                  std::uint16_t port, Deadline deadline, bool& may_heal) {
  may_heal = true;
  const bool v6 = host.find(':') != std::string::npos;
  const std::string target = fmt::format("{}{}{}:{}", v6 ? "[" : "", host, v6 ? "]" : "", port);
  std::string request = fmt::format("CONNECT {0} HTTP/1.1\r\nHost: {0}\r\n", target);
  if (!proxy.credentials.empty()) {
    request += fmt::format("Proxy-Authorization: Basic {}\r\n", Base64(proxy.credentials));
  }
  request += "\r\n";
  // A fresh connection takes a request of this size whole.
  const ssize_t sent = send(descriptor, request.data(), request.size(), MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(request.size())) {
    return ProxyFailed("the proxy broke the connection");
  }
  const auto answer = ReadAnswer(descriptor, deadline);
  if (!answer) return Fail(answer.error());
  const std::string status =
      answer->starts_with("HTTP/1.") && answer->size() > 12 ? answer->substr(9, 3) : "";
  if (status == "200") return {};
  may_heal = IsPassing(status);
  if (status.empty()) return ProxyFailed("what answers there is no HTTP proxy: check --proxy");
  if (status == "407" && proxy.credentials.empty()) {
    return ProxyFailed(
        "the proxy wants a user name and a password: set FLEETPUB_PROXY to "
        "http://user:password@host:port");
  }
  if (status == "407") {
    return ProxyFailed("the proxy refuses the user name or the password in FLEETPUB_PROXY");
  }
  return ProxyFailed(fmt::format("the proxy {} {} (HTTP status {})",
                                 may_heal ? "does not reach" : "refuses", target,
                                 base::Printable(status)));
}

}  // namespace fleetpub::mqtt
