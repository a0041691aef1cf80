// What SQLite's result codes mean to a person who wants to command a robot.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace fleetpub::ledger {

/// What ends a message about a ledger that somebody blocks.
inline constexpr std::string_view kUrgentWay =
    "what cannot wait goes with --ledger and a file of your own";

struct SqliteFailure {
  int code = 0;  ///< extended result code
  int system_error = 0;
  std::string text;
  std::filesystem::path path;
  std::chrono::milliseconds busy_timeout{};
};

/// ErrorKind::kLedger: the file, the cause, the remedy.
[[nodiscard]] Error ExplainSqlite(const SqliteFailure& failure);

/// The file is damaged, or something else altogether.
[[nodiscard]] Error DamagedLedger(const std::filesystem::path& path, std::string detail);

/// This error of the system's kept a file of the ledger from being opened.
[[nodiscard]] Error CannotOpen(const std::filesystem::path& path, int system_error,
                               std::string detail = {});

/// One of the ledger's files is a link, a FIFO or the like; nothing: none is.
[[nodiscard]] std::optional<Error> ExplainIrregularFile(const std::filesystem::path& ledger);

}  // namespace fleetpub::ledger
