#include "mqtt/paho/paho_version.h"

#include <MQTTClient.h>
#include <fmt/format.h>
#include <openssl/crypto.h>

#include <string_view>

namespace fleetpub::mqtt {

std::vector<std::string> LibraryVersions() {
  std::string_view paho = "?";
  for (const auto* info = MQTTClient_getVersionInfo(); info->name != nullptr; ++info) {
    if (std::string_view(info->name) == "Version") paho = info->value;
  }
  return {fmt::format("Paho {}", paho),
          fmt::format("OpenSSL {}", OpenSSL_version(OPENSSL_VERSION_STRING))};
}

}  // namespace fleetpub::mqtt
