// The help texts. Option lines come from the declarations themselves.
#pragma once

#include <string>
#include <string_view>

#include "cli/parser/arguments.h"

namespace fleetpub::cli {

/// `fleetpub`, alone: what it is and the first commands to try.
[[nodiscard]] std::string ShortHelp();

/// `fleetpub --help`: every command, and the global options.
[[nodiscard]] std::string GeneralHelp(const OptionSet& set);

/// `fleetpub pause --help`: usage, own options by group, examples.
[[nodiscard]] std::string CommandHelp(const OptionSet& set, const SubcommandMatch& match);

}  // namespace fleetpub::cli
