// The files of a ledger: making them with the right permissions, and what there is at a path.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "base/result.h"

namespace fleetpub::ledger {

/// True: a regular file is there. False: nothing is. Anything else: ErrorKind::kLedger.
[[nodiscard]] Result<bool> LedgerFileExists(const std::filesystem::path& path);

/// Makes an empty file, and with 0700 the folders that it misses. The file is the user's own
/// (0600), except in a folder that its group may write in: such a folder is shared by all
/// operators, and so is the file (0660), whatever the umask. A file that appeared meanwhile is left
/// as it is.
[[nodiscard]] Status CreateLedgerFile(const std::filesystem::path& path);

/// The size, 0 when there is no such file.
[[nodiscard]] std::uintmax_t SizeOf(const std::filesystem::path& path);

}  // namespace fleetpub::ledger
