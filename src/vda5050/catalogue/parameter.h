// Action parameters: from an operator's text to JSON that a robot accepts.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::vda5050 {

/// One of an action's `actionParameters`.
struct Parameter {
  std::string key;
  std::string json;  ///< the value as JSON text
};

/// The value of a predefined parameter, typed as its row says. Numbers are JSON numbers, never
/// strings: robots refuse "1.5". Lengths may be said in m, cm and mm, angles in rad and deg: they
/// become metres and radians. NaN, infinity and an angle beyond ±π are refused. Errors:
/// ErrorKind::kUsage.
[[nodiscard]] Result<Parameter> ParseParameter(const ParameterSpec& spec, std::string_view text);

/// `key=text`, `key:=json`, `key=@file`, `key:=@file`, as `-P` takes it. Text without `=` is
/// refused without being repeated: to other tools that letter is a password. Errors:
/// ErrorKind::kUsage, kLedger (file).
[[nodiscard]] Result<Parameter> ParseAssignment(std::string_view text);

}  // namespace fleetpub::vda5050
