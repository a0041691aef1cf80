#include "cli/commands/version.h"

#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <set>
#include <string_view>

#include "base/rapidjson.h"
#include "base/text.h"
#include "base/width.h"
#include "ledger/sqlite/sqlite_database.h"
#include "mqtt/paho/paho_version.h"
#include "schema/schema.h"

namespace fleetpub::cli {
namespace {

// `vda5050 1.1.0 2.0.0 …, soar 1.0`
std::string Schemas() {
  std::string text;
  std::string_view protocol;
  const auto list = schema::Registry("").List();
  std::set<std::string> seen;
  for (const auto& [name, origin] : list) {
    const auto parts = base::Split(name, '/');
    if (parts[0] == "fleetpub") continue;  // of what we print ourselves
    if (parts.size() < 2 || !seen.insert(parts[0] + "/" + parts[1]).second) continue;
    if (parts[0] != protocol) text += fmt::format("{}{}", text.empty() ? "" : ", ", parts[0]);
    protocol = std::string_view(name).substr(0, parts[0].size());
    text += " " + parts[1];
  }
  return text;
}

}  // namespace

std::string VersionText(const BuildInfo& build) {
  return fmt::format(
      "fleetpub {}\n"
      "build      {}\n"
      "libraries  {}, SQLite {}, RapidJSON {}, fmt {}.{}.{}, CLI11 {}, utf8proc {}\n"
      "schemas    {}",
      build.version, build.description, base::Join(mqtt::LibraryVersions(), ", "),
      ledger::SqliteVersion(), RAPIDJSON_VERSION_STRING, FMT_VERSION / 10'000,
      FMT_VERSION / 100 % 100, FMT_VERSION % 100, CLI11_VERSION, base::Utf8procVersion(),
      Schemas());
}

}  // namespace fleetpub::cli
