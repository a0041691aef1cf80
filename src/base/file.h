// Reading whole files and streams, within limits.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/result.h"

namespace fleetpub::base {

constexpr std::size_t kMaxFileBytes = std::size_t{64} * 1024 * 1024;

/// The file's bytes; `-` is standard input. A missing file, a folder, one larger than `limit`:
/// ErrorKind::kLedger with the name and the system's reason.
[[nodiscard]] Result<std::string> ReadFile(const std::filesystem::path& path,
                                           std::size_t limit = kMaxFileBytes);

/// Whether a person is to type what is read from there: `-`, and standard input is a terminal.
[[nodiscard]] bool IsTyped(const std::filesystem::path& path);

/// Everything from this descriptor. `name` is for messages. Blocks until the end of input.
[[nodiscard]] Result<std::string> ReadAll(int descriptor, std::string_view name,
                                          std::size_t limit = kMaxFileBytes);

}  // namespace fleetpub::base
