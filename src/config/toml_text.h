// TOML: as JSON, for payloads that people write by hand, and with its places, for configuration.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace fleetpub::config {

/// The document as JSON text: tables as objects, dates and times as strings. Errors:
/// ErrorKind::kInvalid with the line: no TOML (https://toml.io/en/v1.0.0), or a number that JSON
/// does not have.
[[nodiscard]] Result<std::string> TomlToJson(std::string_view text);

struct TomlPlace {
  unsigned line = 0;
  unsigned column = 0;
};

struct TomlMember;

struct TomlValue {
  enum class Type { kText, kInteger, kNumber, kBoolean, kTime, kArray, kTable };
  Type type = Type::kTable;
  TomlPlace place;
  std::string text;                 ///< of a text; an integer or boolean as written
  std::vector<TomlValue> items;     ///< of an array
  std::vector<TomlMember> members;  ///< of a table, by name
};

struct TomlMember {
  std::string name;
  TomlPlace place;  ///< of its name
  TomlValue value;
};

/// A document with the places of everything in it. Errors: ErrorKind::kUsage beginning with
/// `LINE:COLUMN: `. A line that speaks of a password is never repeated.
[[nodiscard]] Result<TomlValue> ParseToml(std::string_view text);

}  // namespace fleetpub::config
