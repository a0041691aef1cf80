// Where passwords come from: never from the argument list, which every user of the machine can
// read.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "base/result.h"
#include "cli/options/global_options.h"

namespace fleetpub::cli {

inline constexpr std::size_t kLongestPassword = 65'535;  ///< MQTT §3.1.3.5

/// Without its end.
[[nodiscard]] std::string FirstLine(std::string text);

struct FoundPassword {
  std::optional<std::string> text;
  std::string source;  ///< `the password of FLEETPUB_PASSWORD`, `no password`: never itself
};

/// The first of: the prompt of --ask-password, --password-file, FLEETPUB_PASSWORD (removed from the
/// environment once read), the systemd credential `fleetpub.password`, the configuration's
/// password_command, which is run; without any, the prompt when is_login_open and there is a
/// terminal.
[[nodiscard]] Result<FoundPassword> FindPassword(const Context& context, app::Log& log);

/// Takes a variable out of the environment and out of memory, where /proc shows it to the same
/// user.
void ForgetVariable(const char* name);

/// The file of the systemd credential `fleetpub.password`, where there is one.
[[nodiscard]] std::optional<std::string> FindPasswordCredential();

/// Whether the environment brings a password: FLEETPUB_PASSWORD or a systemd credential. It goes
/// before the configuration's password_file and password_command, as the environment goes before
/// the configuration.
[[nodiscard]] bool HasPasswordInEnvironment();

/// The systemd credential `fleetpub.ledger_password`, unless PGPASSWORD says otherwise; nothing:
/// libpq finds it. Errors: ErrorKind::kLedger.
[[nodiscard]] Result<std::optional<std::string>> FindLedgerPassword(app::Log& log);

/// Whether the group or everybody may read this regular file; false when it is not there.
[[nodiscard]] bool CanOthersRead(const std::string& path);

/// The file's bytes, 64 KiB at most. Warns when others may read the file. Errors:
/// ErrorKind::kLedger.
[[nodiscard]] Result<std::string> ReadSecretFile(const std::string& path, app::Log& log);
/// Of such a file the first line.
[[nodiscard]] Result<std::string> ReadPasswordFile(const std::string& path, app::Log& log);

}  // namespace fleetpub::cli
