// Where configuration files are, and how they are read.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "config/config.h"

namespace fleetpub::config {

inline constexpr const char* kHostConfigFile = "/etc/fleetpub/config.toml";

/// $HOME, else what the account says; empty: the user has none.
[[nodiscard]] std::filesystem::path HomeFolder();

/// $XDG_CONFIG_HOME/fleetpub/config.toml, else ~/.config/fleetpub/config.toml; empty: the user has
/// no home.
[[nodiscard]] std::filesystem::path UserConfigFile();

enum class Missing { kIsAllowed, kIsAnError };

/// Reads these files, later ones over earlier ones. Errors: ErrorKind::kUsage, with the place when
/// there is one: a file that cannot be read, that somebody else than root or this user may
/// write or put another in the place of (a group may), or that is wrong. A FIFO is not waited for.
[[nodiscard]] Result<Config> LoadConfigFiles(std::span<const std::filesystem::path> files,
                                             Missing missing,
                                             const std::optional<std::string>& profile);

/// The `file` (of --config), else the host's and the user's, in the order in which they are read.
[[nodiscard]] std::vector<std::filesystem::path> ListConfigFiles(
    const std::optional<std::string>& file);

/// All that is wrong in those files, instead of what stops the reading first; of a file that is not
/// TOML only where that shows. `config` has what is right.
[[nodiscard]] Mistakes CheckConfig(const std::optional<std::string>& file,
                                   const std::optional<std::string>& profile,
                                   const ValueCheck& check, Config& config);

/// The `file` (of --config), else the host's and the user's, which need not be there.
[[nodiscard]] Result<Config> LoadConfig(const std::optional<std::string>& file,
                                        const std::optional<std::string>& profile);

}  // namespace fleetpub::config
