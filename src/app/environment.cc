#include "app/environment.h"

#include <fmt/format.h>

#include <utility>

#include "base/text.h"

namespace fleetpub::app {

std::string FormatSite(const mqtt::BrokerUrl& broker, const std::string& profile) {
  std::string site = broker.ToString();
  if (!profile.empty()) site += fmt::format(" (profile {})", base::Printable(profile));
  return site;
}

Result<Link> Connect(const Environment& environment, Log& log) {
  auto connection = environment.connection();
  if (!connection) return Fail(std::move(connection.error()));
  auto transport = connection->open(std::chrono::steady_clock::now() + connection->timeout);
  if (!transport) return Fail(std::move(transport.error()));
  log.Debug(fmt::format("connected to {}", (*transport)->server().broker.ToString()));
  return Link{*std::move(connection), *std::move(transport)};
}

}  // namespace fleetpub::app
