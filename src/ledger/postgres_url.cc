#include "ledger/postgres_url.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace fleetpub::ledger {
namespace {

constexpr std::string_view kSeparator = "://";
constexpr std::array<std::string_view, 2> kSchemes = {"postgresql", "postgres"};

/// Behind the scheme. The login reaches to the last @ of all: a password with a slash or a question
/// mark in it must not be taken for something else, and shown.
struct Pieces {
  std::string_view scheme;
  std::string_view login;
  std::string_view rest;
};

Pieces Cut(std::string_view url) {
  const std::size_t colon = url.find(kSeparator);
  Pieces pieces{url.substr(0, colon), {}, url.substr(colon + kSeparator.size())};
  const std::size_t at = pieces.rest.rfind('@');
  if (at == std::string_view::npos) return pieces;
  pieces.login = pieces.rest.substr(0, at);
  pieces.rest.remove_prefix(at + 1);
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
  if (pieces.login.find(':') != std::string_view::npos) return true;
  for (const std::string_view part : {pieces.login, pieces.rest}) {
    const std::size_t question = part.find('?');
    if (question == std::string_view::npos) continue;
    const auto parameters = base::Split(part.substr(question + 1), '&');
    if (std::any_of(parameters.begin(), parameters.end(), NamesASecret)) return true;
  }
  return false;
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
                "names, or set PGPASSWORD (an @ behind the user is written %40)");
  }
  if (base::Printable(url) != url) {
    return Fail(ErrorKind::kUsage, "the ledger's URL has a character that no URL has");
  }
  return {};
}

std::string PlaceOf(std::string_view url) {
  const Pieces pieces = Cut(url);
  std::string place = std::string(pieces.scheme) + std::string(kSeparator);
  if (!pieces.login.empty()) {
    const std::size_t colon = pieces.login.find(':');
    place += pieces.login.substr(0, colon);
    if (colon != std::string_view::npos) place += ":********";
    place += '@';
  }
  return place + std::string(pieces.rest.substr(0, pieces.rest.find('?')));
}

}  // namespace fleetpub::ledger
