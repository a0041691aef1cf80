#include "ledger/sqlite/sqlite_error.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>
#include <system_error>

#include "base/time.h"
#include "ledger/ledger_files.h"

namespace fleetpub::ledger {
namespace {

std::string Reason(int system_error) { return std::generic_category().message(system_error); }

bool MeansNoRoom(const SqliteFailure& failure) {
  const int error = failure.system_error;
  return (failure.code & 0xFF) == SQLITE_FULL ||
         ((failure.code & 0xFF) == SQLITE_IOERR &&
          (error == ENOSPC || error == EDQUOT || error == EFBIG));
}

std::string Message(const SqliteFailure& failure) {
  const std::string path = failure.path.string();
  switch (failure.code & 0xFF) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
      return fmt::format(
          "another process has kept the ledger {} locked for {}: try again, or find it with `fuser "
          "{}`; {}",
          path, base::FormatElapsed(failure.busy_timeout), path, kUrgentWay);
    case SQLITE_INTERRUPT:
      return fmt::format(
          "the ledger {} took too long: its disk is slow, or it holds what fleetpub "
          "did not write; {}",
          path, kUrgentWay);
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return fmt::format(
          "the ledger {} cannot be written: give yourself write permission for the file and its "
          "folder, or name another with --ledger",
          path);
    case SQLITE_IOERR:
      return fmt::format(
          "reading or writing the ledger {} failed ({}): check the disk", path,
          failure.system_error == 0 ? "no reason is known" : Reason(failure.system_error));
    default:
      return fmt::format("the ledger {} failed (SQLite code {}): try again; -v tells more", path,
                         failure.code);
  }
}

}  // namespace

Error DamagedLedger(const std::filesystem::path& path, std::string detail) {
  return {ErrorKind::kLedger,
          fmt::format("{0} is damaged or no ledger: save what can be saved with `sqlite3 {0} "
                      ".recover`, then move it and {0}-wal aside, and leave "
                      "{0}.locks: header ids go on where it says",
                      path.string()),
          std::move(detail)};
}

Error CannotOpen(const std::filesystem::path& path, int system_error, std::string detail) {
  return {ErrorKind::kLedger,
          fmt::format("cannot open the ledger {} ({}): check its permissions and those of its "
                      "folder, or name another with --ledger",
                      path.string(), Reason(system_error)),
          std::move(detail)};
}

std::optional<Error> ExplainIrregularFile(const std::filesystem::path& ledger) {
  const std::filesystem::path irregular = FindIrregularFile(ledger);
  if (irregular.empty()) return std::nullopt;
  return Error{ErrorKind::kLedger,
               fmt::format("the ledger's {} is a link or no regular file, and is not opened: find "
                           "out who put it there, and remove it",
                           irregular.string()),
               {}};
}

Error ExplainSqlite(const SqliteFailure& failure) {
  const int primary = failure.code & 0xFF;
  if (primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB) {
    return DamagedLedger(failure.path, failure.text);
  }
  if (primary == SQLITE_CANTOPEN || primary == SQLITE_READONLY || primary == SQLITE_IOERR) {
    if (auto trap = ExplainIrregularFile(failure.path)) return *std::move(trap);
  }
  if (primary == SQLITE_CANTOPEN) {
    const int error = failure.system_error == 0 ? EACCES : failure.system_error;
    return CannotOpen(failure.path, error, failure.text);
  }
  if (MeansNoRoom(failure)) {
    return {ErrorKind::kLedger,
            fmt::format("no room for the ledger {}: free some space on its disk",
                        failure.path.string()),
            failure.text};
  }
  return {ErrorKind::kLedger, Message(failure), failure.text};
}

}  // namespace fleetpub::ledger
