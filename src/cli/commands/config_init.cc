// `fleetpub config init`: a commented configuration to begin with.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config_files.h"

namespace fleetpub::cli {
namespace {

namespace fs = std::filesystem;

// Every setting, so that nobody needs another list. A test reads it with each line uncommented.
constexpr std::string_view kStarter =
    R"(# Configuration of fleetpub. `fleetpub config show` prints what is in force and where it comes from.
# A line without # at its beginning is in force. A flag goes before its environment variable, that
# before a profile, that before the rest of this file. Paths are relative to this file's folder.

#broker = "mqtts://broker.example:8883"   # or a list, tried in its order: ["mqtts://a", "mqtts://b"]
#username = "operator"
#password_file = "password"               # its first line; chmod 600. No password stands in here
#auth_method = "OAUTH2-JWT"               # MQTT 5: a token broker's enhanced authentication
#auth_data_file = "token"                 # what that method takes
#client_id = "fleetpub-desk-1"            # left out: a random one
#keep_alive = 60                          # seconds
#mqtt_version = "3.1.1"                   # or 5
#user_property = ["desk=night shift"]     # MQTT 5: sent along with each message
#message_expiry = "30s"                   # MQTT 5: a robot that is offline for longer never gets it
#connect_timeout = "10s"
#proxy = "http://proxy.example:3128"
#qos = 0                                  # 1, 2: wait for the broker's acknowledgement

# TLS. Without cafile or capath the system's authorities are trusted.
#cafile = "ca.pem"
#capath = "/etc/ssl/plant"
#cert = "operator.pem"
#key = "operator.key"
#key_password_file = "key-password"
#ciphers = "ECDHE+AESGCM"
#tls_server_name = "broker.example"      # when the URL has another name, or an address
#tls_alpn = ["mqtt"]
# Without verification anyone could be the broker. Both lines, or none:
#insecure = true
#allow_insecure = true

#output = "text"                          # or "json", "csv", "tsv"
#ledger = "/var/lib/fleetpub/ledger.db"   # or, shared by hosts: "postgresql://operator@db.example/fleet"
#no_history = false
#header_id_start = "zero"                 # or "epoch": Unix seconds, for a ledger that may get lost
#schema_dir = "schemas"
#layout = "hall.lif.json"                 # where robots drive (LIF)

# VDA 5050: what is spoken to robots that have no table of their own below.
#vda = "3.0.0"                            # "auto": each robot's own
#tidy = false                             # true: clear a robot's list of instant actions after --wait
#interface = "vda5050"
#topic_template = "{interface}/{major}/{manufacturer}/{serial}/{topic}"

# SoAR
#soar_source = "fleetpub"
#soar_prefix = "soar"

#default_profile = "north"                # in use when nobody says --profile

# A profile is a site: any of the settings above, under a name.
#[profile.north]
#broker = "mqtts://north.example:8883"
#username = "operator"
#password_file = "north-password"

#[profile.south]
#broker = ["mqtts://south-1.example:8883", "mqtts://south-2.example:8883"]
#password_command = ["pass", "show", "fleet/south"]   # prints it; instead of password_file
#vda = "2.1.0"

# A robot that is spoken to in its own way, and by a short name: fleetpub pause agv1
#[robot."KIT/0001"]
#alias = "agv1"
#vda = "2.0.0"
#interface = "uagv"
#topic_template = "{interface}/{major}/{manufacturer}/{serial}/{topic}"
#actions_key = "instantActions"           # some 2.0 robots expect it
#header_version = "2.0"                   # where a header differs from version and topic
#header_manufacturer = "KIT"
#header_serial = "1"

# Groups of robots and aliases: fleetpub pause @hall-1
#[group]
#hall-1 = ["KIT/0002", "agv1"]
)";

struct ConfigInitOptions {
  bool to_stdout = false;
  std::string place;
};

tl::unexpected<Error> CannotWrite(const fs::path& file, std::string_view why) {
  return Fail(ErrorKind::kLedger,
              fmt::format("cannot write {}: {}", base::Printable(file.string()), why));
}

Status WriteAll(int descriptor, std::string_view text, const fs::path& file) {
  while (!text.empty()) {
    const ssize_t count = write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CannotWrite(file, std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

// Never over something that is there, be it a dangling link.
Status WriteStarter(const fs::path& file) {
  std::error_code trouble;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), trouble);
  if (trouble) return CannotWrite(file, trouble.message());
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0 && errno == EEXIST) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} exists and stays as it is. try: fleetpub config init --stdout",
                            base::Printable(file.string())));
  }
  if (descriptor < 0) return CannotWrite(file, std::strerror(errno));
  auto written = WriteAll(descriptor, kStarter, file);
  if (close(descriptor) != 0 && written) written = CannotWrite(file, std::strerror(errno));
  return written;
}

Result<ExitCode> RunConfigInit(const ConfigInitOptions& options, const Context& context) {
  if (!options.place.empty() && options.place != "-") {
    return Fail(ErrorKind::kUsage,
                fmt::format("config init takes - for standard output, not '{}'; --config FILE "
                            "names the file to write",
                            base::Printable(options.place)));
  }
  if (options.to_stdout || !options.place.empty()) {
    context.output.Line(kStarter.substr(0, kStarter.size() - 1));
    return ExitCode::kDone;
  }
  const fs::path file = context.options.config_file ? fs::path(*context.options.config_file)
                                                    : config::UserConfigFile();
  if (file.empty()) {
    return Fail(ErrorKind::kUsage,
                "no place for the configuration: this user has no home folder; set HOME or name "
                "a file with --config");
  }
  if (auto ok = WriteStarter(file); !ok) return Fail(std::move(ok.error()));
  context.output.PeopleLine(fmt::format("written to {}", base::Printable(file.string())));
  return ExitCode::kDone;
}

}  // namespace

Run DeclareConfigInit(OptionSet& set) {
  const auto options = std::make_shared<ConfigInitOptions>();
  set.AddOption("place", options->place, "-: standard output").Type("-");
  set.AddFlag("--stdout", options->to_stdout, "Print it, write no file").Group("Writing");
  return [options](const Context& context) { return RunConfigInit(*options, context); };
}

}  // namespace fleetpub::cli
