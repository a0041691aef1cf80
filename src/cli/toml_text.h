// TOML as JSON, for payloads that people write by hand.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::cli {

/// The document as JSON text: tables as objects, dates and times as strings. Errors:
/// ErrorKind::kInvalid with the line: no TOML (https://toml.io/en/v1.0.0), or a number that JSON
/// does not have.
[[nodiscard]] Result<std::string> TomlToJson(std::string_view text);

}  // namespace fleetpub::cli
