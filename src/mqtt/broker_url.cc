#include "mqtt/broker_url.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "base/text.h"

namespace fleetpub::mqtt {
namespace {

// Far above any real one (a DNS name ends at 253); what is longer is a mistake or an attack.
constexpr std::size_t kMaximumLength = 2048;
constexpr std::size_t kMaximumHostLength = 253;

struct SchemeInfo {
  std::string_view name;
  Scheme scheme;
  std::uint16_t port;
};
constexpr std::array<SchemeInfo, 4> kSchemes{{
    {"mqtt", Scheme::kMqtt, 1883},
    {"mqtts", Scheme::kMqtts, 8883},
    {"ws", Scheme::kWs, 80},
    {"wss", Scheme::kWss, 443},
}};

// What other programs call the same thing.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kOtherNames{{
    {"tcp", "mqtt"},
    {"mqtt+tcp", "mqtt"},
    {"ssl", "mqtts"},
    {"tls", "mqtts"},
    {"mqtt+ssl", "mqtts"},
    {"mqtt+tls", "mqtts"},
    {"http", "ws"},
    {"https", "wss"},
}};

constexpr std::string_view kForm = "write mqtt://host, mqtts://host:8883 or ws://host:port/path";

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7F;
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// RFC 3986 §2.1. Nothing when an escape is incomplete or stands for a control character: no name
// has one.
std::optional<std::string> PercentDecode(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const int high = HexDigit(text[i + 1]);
    const int low = HexDigit(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    if (IsControl(decoded.back())) return std::nullopt;
    i += 2;
  }
  return decoded;
}

// The pieces of a URL as written. What a person typed is repeated in an error only when there is no
// `@` in it: before an `@` a password may stand, wherever it was meant to go.
struct Pieces {
  std::string_view scheme;
  std::string_view user;
  bool has_user = false;
  std::string_view authority;
  std::string_view path;
  bool may_repeat = true;

  [[nodiscard]] std::string Quoted(std::string_view text) const {
    return may_repeat ? fmt::format(" \"{}\"", base::Printable(text)) : std::string();
  }
};

Status CheckCharacters(std::string_view text) {
  if (text.empty())
    return Fail(ErrorKind::kUsage, fmt::format("the broker URL is empty: {}", kForm));
  if (text.size() > kMaximumLength) {
    return Fail(ErrorKind::kUsage, fmt::format("the broker URL is longer than {} characters: {}",
                                               kMaximumLength, kForm));
  }
  if (std::any_of(text.begin(), text.end(), IsControl)) {
    return Fail(ErrorKind::kUsage,
                fmt::format("the broker URL contains a control character: {}", kForm));
  }
  if (text.find(' ') != std::string_view::npos) {
    return Fail(ErrorKind::kUsage, fmt::format("the broker URL contains a space: {}", kForm));
  }
  if (!base::IsUtf8(text))
    return Fail(ErrorKind::kUsage, fmt::format("the broker URL is not UTF-8: {}", kForm));
  return {};
}

Result<Pieces> Split(std::string_view text) {
  Pieces pieces;
  pieces.may_repeat = text.find('@') == std::string_view::npos;
  const std::size_t scheme_end = text.find("://");
  if (scheme_end == std::string_view::npos) {
    if (!pieces.may_repeat || text.find("//") != std::string_view::npos) {
      return Fail(ErrorKind::kUsage, fmt::format("the broker URL has no scheme: {}", kForm));
    }
    return Fail(ErrorKind::kUsage, fmt::format("\"{0}\" is not a broker URL: write mqtt://{0}",
                                               base::Printable(text)));
  }
  pieces.scheme = text.substr(0, scheme_end);
  std::string_view rest = text.substr(scheme_end + 3);
  // The last @ of all, even behind a slash: a password with a slash in it must not be taken for a
  // path and shown.
  if (const std::size_t at = rest.rfind('@'); at != std::string_view::npos) {
    pieces.has_user = true;
    pieces.user = rest.substr(0, at);
    rest = rest.substr(at + 1);
  }
  const std::size_t authority_end = std::min(rest.find_first_of("/?#"), rest.size());
  pieces.authority = rest.substr(0, authority_end);
  pieces.path = rest.substr(authority_end);
  return pieces;
}

Result<SchemeInfo> ParseScheme(std::string_view name) {
  const std::string lower = base::ToLower(name);
  for (const SchemeInfo& info : kSchemes) {
    if (lower == info.name) return info;
  }
  for (const auto& [other, ours] : kOtherNames) {
    if (lower == other) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("{0}:// is not a scheme of a broker URL: write {1}://", lower, ours));
    }
  }
  return Fail(ErrorKind::kUsage,
              fmt::format("the scheme of the broker URL is not known: {}", kForm));
}

Result<std::string> ParseUser(const Pieces& pieces) {
  if (!pieces.has_user) return std::string();
  if (pieces.user.find(':') != std::string_view::npos) {
    return Fail(
        ErrorKind::kUsage,
        "a broker URL carries no password, since other users of this machine can read it in the "
        "process list: "
        "use --password-file or FLEETPUB_PASSWORD (a : in a user name is written %3A)");
  }
  if (pieces.user.empty()) {
    return Fail(
        ErrorKind::kUsage,
        "the broker URL has an @ without a user name: write mqtt://user@host or mqtt://host");
  }
  if (pieces.user.find_first_of("@/?#") != std::string_view::npos) {
    return Fail(
        ErrorKind::kUsage,
        "the user name in the broker URL contains @, /, ? or #: write them as %40, %2F, %3F, %23");
  }
  auto user = PercentDecode(pieces.user);
  if (!user || !base::IsUtf8(*user)) {
    return Fail(ErrorKind::kUsage,
                "the user name in the broker URL has a bad percent escape: write % as %25, and two "
                "hexadecimal digits after "
                "each %");
  }
  return *std::move(user);
}

bool IsIpv6(const std::string& text) {
  in6_addr address{};
  return inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

bool IsHostCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '.' || c == '_';
}

// `fe80::1%25eth0` (RFC 6874) or `::1`, without the brackets.
Result<std::string> ParseIpv6(std::string_view text, const Pieces& pieces) {
  auto host = PercentDecode(text);
  const std::size_t zone = host ? host->find('%') : std::string::npos;
  const bool good = host && IsIpv6(host->substr(0, zone)) &&
                    (zone == std::string::npos ||
                     (zone + 1 < host->size() &&
                      std::all_of(host->begin() + static_cast<std::ptrdiff_t>(zone) + 1,
                                  host->end(), IsHostCharacter)));
  if (!good) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format(
            "the address{} in the broker URL is not an IPv6 address: write mqtt://[::1]:1883, "
            "and a zone as [fe80::1%25eth0]",
            pieces.Quoted(text)));
  }
  return *std::move(host);
}

Result<std::string> ParseHostName(std::string_view text, const Pieces& pieces) {
  if (text.empty())
    return Fail(ErrorKind::kUsage, fmt::format("the broker URL names no host: {}", kForm));
  auto host = PercentDecode(text);
  if (!host || host->empty() || host->size() > kMaximumHostLength ||
      !std::all_of(host->begin(), host->end(), IsHostCharacter)) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format(
            "the host{} in the broker URL is not a host name: it consists of letters, digits, "
            ". and - (and a name with "
            "other letters has an xn-- form)",
            pieces.Quoted(text.substr(0, kMaximumHostLength))));
  }
  return *std::move(host);
}

Result<std::uint16_t> ParsePort(std::string_view text, const Pieces& pieces) {
  unsigned value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || value < 1 || value > 65535) {
    return Fail(ErrorKind::kUsage,
                fmt::format("the port{} in the broker URL is not a number from 1 to 65535",
                            pieces.Quoted(text.substr(0, kMaximumHostLength))));
  }
  return static_cast<std::uint16_t>(value);
}

Status ParseAuthority(const Pieces& pieces, BrokerUrl& url) {
  std::string_view host = pieces.authority;
  std::optional<std::string_view> port;
  if (host.starts_with('[')) {
    const std::size_t close = host.find(']');
    const std::string_view after = close == std::string_view::npos ? "" : host.substr(close + 1);
    if (close == std::string_view::npos || (!after.empty() && after.front() != ':')) {
      return Fail(
          ErrorKind::kUsage,
          "the IPv6 address in the broker URL has no proper brackets: write mqtt://[::1]:1883");
    }
    if (!after.empty()) port = after.substr(1);
    auto address = ParseIpv6(host.substr(1, close - 1), pieces);
    if (!address) return Fail(std::move(address.error()));
    url.host = *std::move(address);
  } else {
    if (std::count(host.begin(), host.end(), ':') > 1) {
      return Fail(ErrorKind::kUsage,
                  "write an IPv6 address in a broker URL in brackets: write mqtt://[::1]:1883");
    }
    if (const std::size_t colon = host.find(':'); colon != std::string_view::npos) {
      port = host.substr(colon + 1);
      host = host.substr(0, colon);
    }
    auto name = ParseHostName(host, pieces);
    if (!name) return Fail(std::move(name.error()));
    url.host = *std::move(name);
  }
  if (port) {
    auto number = ParsePort(*port, pieces);
    if (!number) return Fail(std::move(number.error()));
    url.port = *number;
  }
  return {};
}

Status ParsePath(const Pieces& pieces, BrokerUrl& url) {
  if (pieces.path.find_first_of("?#") != std::string_view::npos) {
    return Fail(ErrorKind::kUsage,
                "a broker URL has no query (?) and no fragment (#): leave them out");
  }
  if (!url.UsesWebSocket()) {
    if (pieces.path.empty() || pieces.path == "/") return {};
    return Fail(
        ErrorKind::kUsage,
        fmt::format(
            "the path{} does not belong in an mqtt:// or mqtts:// URL, only into ws:// and wss://",
            pieces.Quoted(pieces.path)));
  }
  const bool plain = std::all_of(pieces.path.begin(), pieces.path.end(), [](char c) {
    return c > ' ' && c < 0x7F && std::string_view("\"<>\\^`{|}").find(c) == std::string_view::npos;
  });
  if (!plain || !PercentDecode(pieces.path)) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format(
            "the path{} in the broker URL has a character or a percent escape that no path has",
            pieces.Quoted(pieces.path)));
  }
  url.path = pieces.path;
  return {};
}

}  // namespace

std::string BrokerUrl::ToString() const {
  const auto* const info = std::find_if(kSchemes.begin(), kSchemes.end(),
                                        [this](const SchemeInfo& s) { return s.scheme == scheme; });
  std::string shown = host;
  if (host.find(':') != std::string::npos) {
    if (const std::size_t zone = shown.find('%'); zone != std::string::npos) {
      shown.insert(zone + 1, "25");
    }
    shown = "[" + shown + "]";
  }
  return fmt::format("{}://{}:{}{}", info->name, shown, port, path);
}

Result<BrokerUrl> ParseBrokerUrl(std::string_view text) {
  if (auto status = CheckCharacters(text); !status) return Fail(std::move(status.error()));
  const auto pieces = Split(text);
  if (!pieces) return Fail(pieces.error());
  const auto scheme = ParseScheme(pieces->scheme);
  if (!scheme) return Fail(scheme.error());
  auto user = ParseUser(*pieces);
  if (!user) return Fail(std::move(user.error()));
  BrokerUrl url;
  url.scheme = scheme->scheme;
  url.port = scheme->port;
  url.username = *std::move(user);
  if (auto status = ParseAuthority(*pieces, url); !status) return Fail(std::move(status.error()));
  if (auto status = ParsePath(*pieces, url); !status) return Fail(std::move(status.error()));
  return url;
}

}  // namespace fleetpub::mqtt
