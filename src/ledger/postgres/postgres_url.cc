#include "ledger/postgres/postgres_url.h"

#include <algorithm>
#include <array>
#include <optional>

#include "base/text.h"

namespace fleetpub::ledger {
namespace {

constexpr std::string_view kSeparator = "://";
constexpr std::array<std::string_view, 2> kSchemes = {"postgresql", "postgres"};

/// `scheme://user:password@place?parameters`. A password reaches to the last @ of all: one with a
/// slash or a question mark in it must not be taken for something else, and shown.
struct Pieces {
  std::string_view scheme;
  std::string_view behind;                              ///< all that follows the scheme
  std::optional<std::string_view> user = std::nullopt;  ///< of a login with a password
  std::string_view place;
};

Pieces Cut(std::string_view url) {
  const std::size_t end = url.find(kSeparator);
  Pieces pieces{.scheme = url.substr(0, end), .behind = url.substr(end + kSeparator.size())};
  const std::size_t at = pieces.behind.rfind('@');
  const std::size_t colon = pieces.behind.find(':');
  const bool has_password = at != std::string_view::npos && colon < at;
  if (has_password) pieces.user = pieces.behind.substr(0, colon);
  pieces.place = has_password ? pieces.behind.substr(at + 1) : pieces.behind;
  pieces.place = pieces.place.substr(0, pieces.place.find_first_of("?&"));
  return pieces;
}

/// A name with a percent escape might be any.
bool NamesASecret(std::string_view parameter) {
  const std::string name = base::ToLower(parameter.substr(0, parameter.find('=')));
  for (const std::string_view word : {"password", "secret", "scram_", "%"}) {
    if (name.find(word) != std::string::npos) return true;
  }
  return false;
}

bool HoldsASecret(const Pieces& pieces) {
  if (pieces.user) return true;
  const std::size_t question = pieces.behind.find('?');
  if (question == std::string_view::npos) return false;
  const auto parameters = base::Split(pieces.behind.substr(question + 1), '&');
  return std::any_of(parameters.begin(), parameters.end(), NamesASecret);
}

}  // namespace

bool IsUrl(std::string_view ledger) { return ledger.find(kSeparator) != std::string_view::npos; }

Status CheckPostgresUrl(std::string_view url) {
  const Pieces pieces = Cut(url);
  if (std::find(kSchemes.begin(), kSchemes.end(), pieces.scheme) == kSchemes.end()) {
    return Fail(ErrorKind::kUsage,
                "a ledger is a file or postgresql://[user@]host[:port]/database, not " +
                    base::Printable(pieces.scheme) + "://");
  }
  if (HoldsASecret(pieces)) {
    return Fail(ErrorKind::kUsage,
                "a ledger's URL carries no password, since other users of this machine can read it "
                "in the process list: put it into ~/.pgpass (chmod 600) or a file that PGPASSFILE "
                "names, or set PGPASSWORD (an @ that ends no user name is written %40)");
  }
  if (base::Printable(url) != url) {
    return Fail(ErrorKind::kUsage, "the ledger's URL has a character that no URL has");
  }
  return {};
}

std::string FormatPlace(std::string_view url) {
  const Pieces pieces = Cut(url);
  std::string text = std::string(pieces.scheme) + std::string(kSeparator);
  if (pieces.user) text += std::string(*pieces.user) + ":********@";
  return text + std::string(pieces.place);
}

}  // namespace fleetpub::ledger
