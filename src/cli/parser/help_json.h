// The help as JSON, for programs.
#pragma once

#include <string>

#include "cli/parser/command_line.h"

namespace fleetpub::cli {

/// One object (docs/manual.md, "JSON"): the command that the call names, those of a family, or all,
/// with their options; the options that every command takes; the exit codes.
[[nodiscard]] std::string HelpJson(const CommandLine& call);

}  // namespace fleetpub::cli
