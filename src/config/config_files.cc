#include "config/config_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/account.h"
#include "base/file.h"
#include "base/text.h"
#include "config/config_settings.h"

namespace fleetpub::config {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestConfig = std::size_t{1} << 20U;

std::string FromEnvironment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

tl::unexpected<Error> Unreadable(const std::string& file, std::string_view why) {
  return Fail(ErrorKind::kUsage,
              fmt::format("the configuration {} cannot be read: {}", base::Printable(file), why));
}

// Who can write it, or put another in its place, names the broker that gets the login, and whether
// it is verified.
tl::unexpected<Error> Refused(const std::string& file, const std::string& why) {
  return Fail(ErrorKind::kUsage,
              fmt::format("the configuration {} is refused: {}", base::Printable(file), why));
}

// Root may name anybody's file outright: he reads it as a guest in a container, for example.
bool IsTrusted(uid_t owner, Missing missing) {
  const uid_t self = geteuid();
  return owner == 0 || owner == self || (self == 0 && missing == Missing::kIsAnError);
}

std::string FormatUser(uid_t user) {
  const auto account = base::FindAccount(user);
  return account ? base::Printable(account->name) : fmt::format("user {}", user);
}

// The folder that the file is in, and those above it.
Status CheckFolder(const fs::path& folder, const std::string& file, Missing missing) {
  struct stat status {};
  for (fs::path place = folder;; place = place.parent_path()) {
    if (stat(place.c_str(), &status) != 0) return Unreadable(file, std::strerror(errno));
    const std::string name = base::Printable(place.string());
    if (place == folder && !IsTrusted(status.st_uid, missing)) {
      return Refused(file, fmt::format("its folder {} belongs to {}, who can put another in its "
                                       "place: keep it in a folder of your own or of root",
                                       name, FormatUser(status.st_uid)));
    }
    if ((status.st_mode & S_IWOTH) != 0 && (status.st_mode & S_ISVTX) == 0) {
      return Refused(file,
                     fmt::format("everybody can put another in its place: chmod o-w {}", name));
    }
    if (place == place.parent_path()) return {};
  }
}

Status CheckRegularFile(const struct stat& status, const std::string& file, Missing missing) {
  if ((status.st_mode & S_IWOTH) != 0) {
    return Refused(file, fmt::format("everybody can write it, and with it choose the broker that "
                                     "gets your login: chmod o-w {}",
                                     base::Printable(file)));
  }
  if (!IsTrusted(status.st_uid, missing)) {
    return Refused(file, fmt::format("it belongs to {}, who can choose the broker that gets your "
                                     "login: let it be yours or root's",
                                     FormatUser(status.st_uid)));
  }
  std::error_code failed;
  const fs::path named = fs::absolute(file, failed);
  if (auto ok = CheckFolder(named.parent_path(), file, missing); !ok) return ok;
  const fs::path real = fs::canonical(named, failed);  // another one where links lead elsewhere
  return failed ? Unreadable(file, failed.message())
                : CheckFolder(real.parent_path(), file, missing);
}

// The same more strictly: who else may write the file, or put another in its place; empty: nobody.
std::string FindSharing(const fs::path& folder) {
  struct stat status {};
  for (fs::path place = folder;; place = place.parent_path()) {
    const std::string name = base::Printable(place.string());
    if (stat(place.c_str(), &status) != 0) return fmt::format("{}: {}", name, strerror(errno));
    if (!IsTrusted(status.st_uid, Missing::kIsAllowed)) {
      return fmt::format("{} belongs to {}", name, FormatUser(status.st_uid));
    }
    if ((status.st_mode & S_IWGRP) != 0 && (status.st_mode & S_ISVTX) == 0) {
      return fmt::format("the group of {0} can put another file in its place: chmod g-w {0}", name);
    }
    if (place == place.parent_path()) return {};
  }
}

std::string FindSharing(const struct stat& status, const std::string& file) {
  if (!S_ISREG(status.st_mode)) return {};
  if (!IsTrusted(status.st_uid, Missing::kIsAllowed)) {
    return fmt::format("the file belongs to {}", FormatUser(status.st_uid));
  }
  if ((status.st_mode & S_IWGRP) != 0) {
    return fmt::format("its group can write it: chmod g-w {}", base::Printable(file));
  }
  std::error_code failed;
  const fs::path named = fs::absolute(file, failed);
  std::string sharing = FindSharing(named.parent_path());
  const fs::path real = fs::canonical(named, failed);
  if (failed || !sharing.empty()) return failed ? failed.message() : sharing;
  return FindSharing(real.parent_path());
}

// A shell hands us a pipe for `<(…)`; a FIFO with a name may never be written to.
bool IsNamedFifo(int descriptor, const struct stat& status) {
  constexpr auto kPipes = 0x50495045;  // PIPEFS_MAGIC of statfs(2)
  struct statfs system {};
  return S_ISFIFO(status.st_mode) && (fstatfs(descriptor, &system) != 0 || system.f_type != kPipes);
}

Status CheckFile(int descriptor, const std::string& file, Missing missing, struct stat& status) {
  if (fstat(descriptor, &status) != 0) return Unreadable(file, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) return Unreadable(file, "it is a folder");
  if (IsNamedFifo(descriptor, status)) return Unreadable(file, "it is a FIFO");
  // Opened without waiting; a pipe is waited for.
  if (fcntl(descriptor, F_SETFL, 0) != 0) return Unreadable(file, std::strerror(errno));
  return S_ISREG(status.st_mode) ? CheckRegularFile(status, file, missing) : Status();
}

struct Opened {
  std::string text;
  struct stat status;
};

// Nothing when there is no such file.
Result<std::optional<Opened>> ReadText(const std::string& file, Missing missing) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    if (missing == Missing::kIsAllowed && (errno == ENOENT || errno == ENOTDIR)) {
      return std::optional<Opened>();
    }
    return Unreadable(file, std::strerror(errno));
  }
  Result<std::optional<Opened>> opened;
  struct stat status {};
  if (auto ok = CheckFile(descriptor, file, missing, status); !ok) {
    opened = Fail(std::move(ok.error()));
  } else if (auto content = base::ReadAll(descriptor, base::Printable(file), kLargestConfig)) {
    opened = Opened{*std::move(content), status};
  } else {
    opened = Fail(ErrorKind::kUsage, std::move(content.error().message));
  }
  close(descriptor);
  return opened;
}

// What names a program to run must be ours or root's alone.
ValueCheck WithSharing(const struct stat& status, std::string file, ValueCheck check) {
  return [status, file = std::move(file), check = std::move(check)](
             std::string_view key, const std::vector<std::string>& texts) -> Status {
    const std::string sharing = key == kPasswordCommand ? FindSharing(status, file) : "";
    if (!sharing.empty()) {
      return Fail(ErrorKind::kUsage,
                  fmt::format("{}: others can choose the program that is run: {}", key, sharing));
    }
    return check ? check(key, texts) : Status();
  };
}

}  // namespace

fs::path HomeFolder() {
  fs::path home = FromEnvironment("HOME");
  if (home.is_absolute()) return home;
  const auto account = base::FindAccount(getuid());
  return account ? fs::path(account->home) : fs::path();
}

fs::path UserConfigFile() {
  const fs::path folder = FromEnvironment("XDG_CONFIG_HOME");
  if (folder.is_absolute()) return folder / "fleetpub" / "config.toml";
  const fs::path home = HomeFolder();
  return home.is_absolute() ? home / ".config" / "fleetpub" / "config.toml" : fs::path();
}

Result<Config> LoadConfigFiles(std::span<const fs::path> files, Missing missing,
                               const std::optional<std::string>& profile) {
  Config config;
  for (const fs::path& file : files) {
    auto opened = ReadText(file.string(), missing);
    if (!opened) return Fail(std::move(opened.error()));
    if (!*opened) continue;
    Mistakes mistakes;
    ReadConfig((*opened)->text, file.string(), config, mistakes,
               WithSharing((*opened)->status, file.string(), {}));
    if (!mistakes.empty()) return Fail(std::move(mistakes.front()));
  }
  if (auto ok = Resolve(profile, config); !ok) return Fail(ok.error());
  return config;
}

std::vector<fs::path> ListConfigFiles(const std::optional<std::string>& file) {
  if (file) return {*file};
  std::vector<fs::path> files = {kHostConfigFile};
  if (fs::path user = UserConfigFile(); !user.empty()) files.push_back(std::move(user));
  return files;
}

Mistakes CheckConfig(const std::optional<std::string>& file,
                     const std::optional<std::string>& profile, const ValueCheck& check,
                     Config& config) {
  Mistakes mistakes;
  for (const fs::path& each : ListConfigFiles(file)) {
    auto opened = ReadText(each.string(), file ? Missing::kIsAnError : Missing::kIsAllowed);
    if (!opened) {
      mistakes.push_back(std::move(opened.error()));
    } else if (*opened) {
      ReadConfig((*opened)->text, each.string(), config, mistakes,
                 WithSharing((*opened)->status, each.string(), check));
    }
  }
  Resolve(profile, config, mistakes);
  return mistakes;
}

Result<Config> LoadConfig(const std::optional<std::string>& file,
                          const std::optional<std::string>& profile) {
  return LoadConfigFiles(ListConfigFiles(file), file ? Missing::kIsAnError : Missing::kIsAllowed,
                         profile);
}

}  // namespace fleetpub::config
