#include "ledger/topic_locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/time.h"
#include "ledger/backoff.h"
#include "ledger/ledger_files.h"
#include "ledger/sqlite/sqlite_error.h"

namespace fleetpub::ledger {
namespace {

using Clock = std::chrono::steady_clock;

static_assert(sizeof(off_t) == 8, "topics are spread over 62 bits of offsets");

/// Topics lie below.
constexpr off_t kCreationOffset = off_t{1} << 62;

off_t ComputeOffset(std::string_view topic) {
  return static_cast<off_t>(TopicHash(topic) & ((std::uint64_t{1} << 62) - 1));
}

class FileLock : public TopicLock {
 public:
  explicit FileLock(int fd) : fd_(fd) {}
  /// Closing the only descriptor of its description releases all its locks in one pass.
  ~FileLock() override { close(fd_); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// 0 or an errno.
  [[nodiscard]] int Try(off_t offset) const {
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    range.l_start = offset;
    range.l_len = 1;
    return fcntl(fd_, F_OFD_SETLK, &range) == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

/// Whoever may write the ledger must be able to lock its topics: same mode, and for root same
/// owner.
void TakeOverPermissions(int fd, const std::filesystem::path& ledger) {
  struct stat info {};
  if (lstat(ledger.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return;
  fchmod(fd, info.st_mode & 0777);
  if (geteuid() == 0 && fchown(fd, info.st_uid, info.st_gid) != 0) return;
}

Result<std::unique_ptr<FileLock>> OpenLockFile(const std::filesystem::path& ledger) {
  const std::string path = ledger.string() + ".locks";
  int fd = OpenRegular(path.c_str(), O_RDWR);
  if (fd < 0 && errno == ENOENT) {
    if (Status made = CreateEmptyFile(path); !made) return Fail(made.error());
    fd = OpenRegular(path.c_str(), O_RDWR);
    if (fd >= 0) TakeOverPermissions(fd, ledger);
  }
  if (fd < 0) {
    const int reason = errno;
    auto trap = ExplainIrregularFile(ledger);
    return Fail(trap ? *std::move(trap) : CannotOpen(path, reason));
  }
  return std::make_unique<FileLock>(fd);
}

/// 0, or the errno of the last attempt: EAGAIN when the deadline passed.
int LockUntil(const FileLock& lock, off_t offset, Deadline deadline) {
  for (int attempt = 0;; ++attempt) {
    const int error = lock.Try(offset);
    const bool held = error == EAGAIN || error == EACCES;
    if (!held) return error;
    const auto now = Clock::now();
    if (now >= deadline) return EAGAIN;
    std::this_thread::sleep_until(std::min<Deadline>(deadline, now + BackoffFor(attempt)));
  }
}

Error Refusal(const std::filesystem::path& ledger, std::string_view what, int error,
              Clock::duration waited) {
  if (error == EAGAIN) {
    return {ErrorKind::kLedger,
            fmt::format("another fleetpub has held {} for {}: try again, or find it with `fuser "
                        "{}.locks`; {}",
                        what, base::FormatElapsed(waited), ledger.string(), kUrgentWay)};
  }
  return {ErrorKind::kLedger,
          fmt::format("cannot lock {}.locks ({}): keep the ledger on a local file system",
                      ledger.string(), std::generic_category().message(error))};
}

}  // namespace

std::uint64_t TopicHash(std::string_view topic) {
  std::uint64_t hash = 14'695'981'039'346'656'037U;
  for (const char c : topic) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1'099'511'628'211U;
  }
  return hash;
}

Result<std::unique_ptr<TopicLock>> LockTopics(const std::filesystem::path& ledger,
                                              std::span<const std::string> topics,
                                              Deadline deadline) {
  const auto start = Clock::now();
  std::vector<std::pair<off_t, std::string_view>> places;
  places.reserve(topics.size());
  for (const std::string& topic : topics) places.emplace_back(ComputeOffset(topic), topic);
  // Everybody goes upwards: whoever waits holds only lower places than the one that he waits for.
  std::sort(places.begin(), places.end());
  Result<std::unique_ptr<FileLock>> lock = OpenLockFile(ledger);
  if (!lock) return Fail(std::move(lock.error()));
  for (const auto& [offset, topic] : places) {
    if (const int error = LockUntil(**lock, offset, deadline); error != 0) {
      return Fail(Refusal(ledger, fmt::format("topic {}", topic), error, Clock::now() - start));
    }
  }
  return std::move(*lock);
}

Result<std::unique_ptr<TopicLock>> LockCreation(const std::filesystem::path& ledger,
                                                Deadline deadline) {
  const auto start = Clock::now();
  Result<std::unique_ptr<FileLock>> lock = OpenLockFile(ledger);
  if (!lock) return Fail(std::move(lock.error()));
  if (const int error = LockUntil(**lock, kCreationOffset, deadline); error != 0) {
    return Fail(Refusal(ledger, "the new ledger", error, Clock::now() - start));
  }
  return std::move(*lock);
}

}  // namespace fleetpub::ledger
