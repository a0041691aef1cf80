// A command that an error suggests, to be pasted into a shell.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace fleetpub::cli {

/// `try: fleetpub pause 'KIT/*' --except KIT/0007`: all of the arguments, since one that is missing
/// could command others, each quoted where a shell would take it for more. Arguments among which
/// may be a password, or that a person cannot see whole, are not repeated: `fleetpub pause -h` then.
[[nodiscard]] std::string TryCommand(std::string_view command,
                                     std::span<const std::string> arguments = {});

/// The words as a line for a shell, each quoted where that is needed. Empty when a person could not
/// see them whole.
[[nodiscard]] std::string ShellLine(std::span<const std::string> words);

}  // namespace fleetpub::cli
