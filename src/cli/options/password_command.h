// A password that a program prints, such as a secret store's: the configuration's
// password_command.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace fleetpub::cli {

inline constexpr std::chrono::milliseconds kPasswordCommandLimit = std::chrono::seconds(30);

/// Runs the program, which is looked for in PATH unless it is a path, with these arguments and
/// without a shell: the first line of what it prints. It sees an empty standard input, our standard
/// error and our environment; what it leaves behind in the background is not waited for. Meanwhile
/// Ctrl-C and `kill` end both at once. `origin` is where the command stands. Errors:
/// ErrorKind::kLedger, never with what was printed.
[[nodiscard]] Result<std::string> RunPasswordCommand(
    const std::vector<std::string>& arguments, std::string_view origin,
    std::chrono::milliseconds limit = kPasswordCommandLimit);

}  // namespace fleetpub::cli
