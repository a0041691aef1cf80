#include "ledger/ledger_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "base/account.h"
#include "ledger/sqlite/sqlite_error.h"
#include "ledger/sqlite/sqlite_ledger.h"

namespace fleetpub::ledger {
namespace {

namespace fs = std::filesystem;

/// f_type of statfs(2), for file systems that several hosts may have mounted.
constexpr std::array<unsigned, 10> kNetworkFileSystems = {
    0x00006969,  // NFS
    0x0000517B,  // SMB
    0xFF534D42,  // CIFS
    0xFE534D42,  // SMB2
    0x65735546,  // FUSE: sshfs, GlusterFS
    0x01021997,  // 9P
    0x00C36400,  // Ceph
    0x5346414F,  // AFS
    0x0BD00BD0,  // Lustre
    0x786F4256,  // VirtualBox shared folder
};

/// A new name is on the disk only when its folder is: after a power failure a ledger must not be
/// gone.
void SyncFolder(const fs::path& folder) {
  const fs::path name = folder.empty() ? fs::path(".") : folder;
  const int fd = open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  fsync(fd);
  close(fd);
}

mode_t ModeFor(const fs::path& folder) {
  struct stat info {};
  if (stat(folder.empty() ? "." : folder.c_str(), &info) != 0) return 0600;
  const bool shared = (info.st_mode & S_IWGRP) != 0 && (info.st_mode & S_IWOTH) == 0;
  return shared ? 0660 : 0600;
}

std::string FromEnvironment(const char* name) {
  const char* value = getenv(name);
  return value == nullptr ? std::string() : value;
}

std::string HomeFolder() {
  std::string home = FromEnvironment("HOME");
  if (!home.empty()) return home;
  const auto account = base::FindAccount(geteuid());
  return account ? account->home : std::string();
}

bool IsLink(const fs::path& path) {
  struct stat info {};
  return lstat(path.c_str(), &info) == 0 && S_ISLNK(info.st_mode);
}

bool OthersMayWriteIn(const fs::path& folder) {
  struct stat info {};
  return stat(folder.c_str(), &info) != 0 || (info.st_mode & (S_IWGRP | S_IWOTH)) != 0;
}

/// The first link among the path's parts, or an empty path.
fs::path FindLink(const fs::path& path) {
  fs::path place;
  for (const fs::path& part : path) {
    place /= part;
    if (IsLink(place)) return place;
  }
  return {};
}

}  // namespace

Result<fs::path> ResolveLinks(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel
  std::error_code failed;
  fs::path place = fs::absolute(path, failed);
  for (int links = 0; links <= kMostLinks && !failed; ++links) {
    const fs::path link = FindLink(place);
    if (link.empty()) return place.lexically_normal();
    if (OthersMayWriteIn(link.parent_path())) {
      return Fail(ErrorKind::kLedger,
                  fmt::format("the ledger's {} is a link in a folder that others can write in, and "
                              "is not followed: name the file that it leads to",
                              link.string()));
    }
    fs::path target = link.parent_path() / fs::read_symlink(link, failed);
    if (link != place) target /= place.lexically_relative(link);
    place = std::move(target);
  }
  return Fail(CannotOpen(path, failed ? failed.value() : ELOOP));
}

int OpenRegular(const char* path, int flags, mode_t mode) {
  const int fd = open(path, flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, mode);
  struct stat info {};
  if (fd < 0) return fd;
  if (fstat(fd, &info) == 0 && (S_ISREG(info.st_mode) || S_ISDIR(info.st_mode))) return fd;
  close(fd);
  errno = ENXIO;
  return -1;
}

fs::path FindIrregularFile(const fs::path& ledger) {
  for (const char* end : {"", "-wal", "-shm", "-journal", ".locks", ".new"}) {
    fs::path path = ledger.string() + end;
    struct stat info {};
    if (lstat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode)) return path;
  }
  return {};
}

Result<bool> HasLedgerFile(const fs::path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) {
    if (errno == ENOENT) return false;
    return Fail(CannotOpen(path, errno));
  }
  if (S_ISREG(info.st_mode)) return info.st_size > 0;
  return Fail(ErrorKind::kLedger,
              fmt::format("the ledger {} is {}: name a file", path.string(),
                          S_ISDIR(info.st_mode) ? "a folder" : "no regular file"));
}

Status MakeFolders(const fs::path& folder) {
  if (folder.empty() || mkdir(folder.c_str(), 0700) == 0) {
    SyncFolder(folder.parent_path());
    return {};
  }
  if (errno == EEXIST) return {};
  if (errno != ENOENT) return Fail(CannotOpen(folder, errno));
  if (Status parent = MakeFolders(folder.parent_path()); !parent) return parent;
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return Fail(CannotOpen(folder, errno));
  SyncFolder(folder.parent_path());
  return {};
}

Status CreateEmptyFile(const fs::path& path) {
  const mode_t mode = ModeFor(path.parent_path());
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
  if (fd < 0) {
    if (errno == EEXIST) return {};
    return Fail(CannotOpen(path, errno));
  }
  fchmod(fd, mode);
  close(fd);
  return {};
}

Status MoveFile(const fs::path& from, const fs::path& to) {
  if (rename(from.c_str(), to.c_str()) != 0) return Fail(CannotOpen(to, errno));
  SyncFolder(to.parent_path());
  return {};
}

std::uintmax_t GetFileSize(const fs::path& path) {
  std::error_code missing;
  const std::uintmax_t size = fs::file_size(path, missing);
  return missing ? 0 : size;
}

bool OnNetworkFileSystem(const fs::path& path) {
  struct statfs info {};
  std::error_code ignored;
  fs::path place = fs::absolute(path, ignored);
  while (statfs(place.c_str(), &info) != 0) {  // what is not there yet will be where its folder is
    if (place == place.parent_path()) return false;
    place = place.parent_path();
  }
  const auto type = static_cast<unsigned>(info.f_type);
  return std::find(kNetworkFileSystems.begin(), kNetworkFileSystems.end(), type) !=
         kNetworkFileSystems.end();
}

Result<fs::path> DefaultLedgerPath(const fs::path& shared_folder) {
  std::error_code ignored;
  if (fs::is_directory(shared_folder, ignored) &&
      eaccess(shared_folder.c_str(), W_OK | X_OK) == 0) {
    return shared_folder / "ledger.db";
  }
  const fs::path state = FromEnvironment("XDG_STATE_HOME");
  if (state.is_absolute()) return state / "fleetpub" / "ledger.db";
  const fs::path home = HomeFolder();
  if (home.is_absolute()) return home / ".local" / "state" / "fleetpub" / "ledger.db";
  return Fail(
      ErrorKind::kLedger,
      "no place for the ledger: this user has no home folder; set HOME or name one with --ledger");
}

}  // namespace fleetpub::ledger
