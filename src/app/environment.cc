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
  const auto deadline = std::chrono::steady_clock::now() + connection->timeout;
  log.Wait("connecting to " + environment.site, deadline);
  auto transport = connection->open(deadline);
  log.Wait("");
  if (!transport) return Fail(std::move(transport.error()));
  log.Debug(fmt::format("connected to {}", (*transport)->server().broker.ToString()));
  return Link{*std::move(connection), *std::move(transport)};
}

delivery::ReconnectHooks MakeReconnectHooks(const Connection& connection, Log& log) {
  return {.open = connection.open,
          .lost = [&log](const Error& error) { log.Lost(error); },
          .again = [&log] { log.ConnectedAgain(); }};
}

}  // namespace fleetpub::app
