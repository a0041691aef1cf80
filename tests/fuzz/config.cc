// A configuration file, and any other TOML.
#include "config/config.h"

#include "base/json.h"
#include "config/toml_text.h"
#include "fuzz/fuzz.h"

using namespace fleetpub;

FUZZ(text) {
  config::Config settings;
  if (const auto read = config::ReadConfig(text, "/f/c.toml", settings); !read) {
    fuzz::Require(read.error().kind == ErrorKind::kUsage && !read.error().message.empty());
  } else {
    static_cast<void>(config::Resolve("north", settings));
    static_cast<void>(config::Resolve(std::nullopt, settings));
  }
  const auto json = config::TomlToJson(text);
  fuzz::Require(!json || base::ParseJson(*json, {.bytes = 1U << 30U, .depth = 1000}));
}
