#include "config/config_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/account.h"
#include "base/file.h"
#include "base/text.h"

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

// Who can write it names the broker that gets the login, and whether it is verified.
Status CheckMode(int descriptor, const std::string& file) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0) return Unreadable(file, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) return Unreadable(file, "it is a folder");
  if (S_ISREG(status.st_mode) && (status.st_mode & S_IWOTH) != 0) {
    return Fail(ErrorKind::kUsage,
                fmt::format("the configuration {0} is refused: everybody can write it, and with it "
                            "choose the broker that gets your login: chmod o-w {0}",
                            base::Printable(file)));
  }
  return {};
}

// Nothing when there is no such file.
Result<std::optional<std::string>> ReadText(const std::string& file, Missing missing) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    if (missing == Missing::kIsAllowed && (errno == ENOENT || errno == ENOTDIR)) {
      return std::optional<std::string>();
    }
    return Unreadable(file, std::strerror(errno));
  }
  Result<std::optional<std::string>> text;
  if (auto ok = CheckMode(descriptor, file); !ok) {
    text = Fail(std::move(ok.error()));
  } else if (auto content = base::ReadAll(descriptor, base::Printable(file), kLargestConfig)) {
    text = *std::move(content);
  } else {
    text = Fail(ErrorKind::kUsage, std::move(content.error().message));
  }
  close(descriptor);
  return text;
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
    const auto text = ReadText(file.string(), missing);
    if (!text) return Fail(text.error());
    if (!*text) continue;
    if (auto ok = ReadConfig(**text, file.string(), config); !ok) return Fail(ok.error());
  }
  if (auto ok = Resolve(profile, config); !ok) return Fail(ok.error());
  return config;
}

Result<Config> LoadConfig(const std::optional<std::string>& file,
                          const std::optional<std::string>& profile) {
  if (file) {
    const std::array<fs::path, 1> one = {*file};
    return LoadConfigFiles(one, Missing::kIsAnError, profile);
  }
  std::vector<fs::path> files = {kHostConfigFile};
  if (fs::path user = UserConfigFile(); !user.empty()) files.push_back(std::move(user));
  return LoadConfigFiles(files, Missing::kIsAllowed, profile);
}

}  // namespace fleetpub::config
