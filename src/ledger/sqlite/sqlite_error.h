// What SQLite's result codes mean to a person who wants to command a robot.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "base/result.h"

namespace fleetpub::ledger {

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

}  // namespace fleetpub::ledger
