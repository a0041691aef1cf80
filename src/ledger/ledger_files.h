// The files of a ledger: making them with the right permissions, and what there is at a path. In a
// folder of a group every name may be somebody else's trap.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "base/result.h"

namespace fleetpub::ledger {

/// The file that a ledger's name means, links resolved; it need not be there yet. A link in a
/// folder that a group or everybody may write in is refused (ErrorKind::kLedger): whoever may write
/// there could lead us to any file of this user's.
[[nodiscard]] Result<std::filesystem::path> ResolveLinks(const std::filesystem::path& path);

/// open(2) of a file beside others' files: no link is followed, no FIFO waited for, and nothing but
/// regular files and folders opened. -1 and errno like open(2); ENXIO for what is neither.
[[nodiscard]] int OpenRegular(const char* path, int flags, mode_t mode = 0);

/// The first of a ledger's files that is a link, a FIFO or the like; empty: none is.
[[nodiscard]] std::filesystem::path FindIrregularFile(const std::filesystem::path& ledger);

/// True: a regular file with something in it is there. False: nothing is, or an empty file.
/// Anything else: ErrorKind::kLedger.
[[nodiscard]] Result<bool> HasLedgerFile(const std::filesystem::path& path);

/// With 0700.
[[nodiscard]] Status MakeFolders(const std::filesystem::path& folder);

/// A new file, or the one that appeared meanwhile. It is the user's own (0600), except in a folder
/// that its group may write in: such a folder is shared by all operators, and so is the file
/// (0660), whatever the umask.
[[nodiscard]] Status CreateEmptyFile(const std::filesystem::path& path);

/// Durable when it returns. Takes the place of a file that is there.
[[nodiscard]] Status MoveFile(const std::filesystem::path& from, const std::filesystem::path& to);

/// The size, 0 when there is no such file.
[[nodiscard]] std::uintmax_t GetFileSize(const std::filesystem::path& path);

}  // namespace fleetpub::ledger
