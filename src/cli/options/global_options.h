// The options that every command takes: broker, output, ledger, schemas.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "cli/output/output.h"
#include "config/config.h"
#include "ledger/ledger.h"
#include "ledger/options.h"
#include "mqtt/transport.h"

namespace fleetpub::cli {

class OptionSet;

struct GlobalOptions {
  std::vector<std::string> brokers;
  std::string host;
  std::optional<std::uint16_t> port;
  std::string username;
  std::string password_file;
  std::vector<std::string> password_command;  ///< empty: none, or something else goes before it
  bool ask_password = false;
  std::string auth_method;
  std::string auth_data_file;
  std::string client_id;
  int keep_alive = 60;  ///< seconds
  mqtt::ProtocolVersion mqtt_version = mqtt::ProtocolVersion::k311;
  std::vector<std::string> user_properties;
  std::optional<std::chrono::milliseconds> message_expiry;
  std::chrono::milliseconds connect_timeout = std::chrono::seconds(10);
  std::string proxy;
  std::string ca_file;
  std::string ca_path;
  std::string cert_file;
  std::string key_file;
  std::string key_password_file;
  std::string ciphers;
  std::string tls_server_name;
  std::vector<std::string> alpn;
  bool insecure = false;

  std::string format = "text";
  std::string fields;  ///< of -o json, csv, tsv; empty: all
  bool quiet = false;
  bool verbose = false;
  std::string debug;           ///< `topics`, `full`; empty: no
  std::string color = "auto";  ///< `auto`, `always`, `never`

  std::string ledger;
  bool no_history = false;
  std::string schema_directory;
  ledger::HeaderIdStart header_id_start = ledger::HeaderIdStart::kZero;

  std::optional<std::string> config_file;
  std::optional<std::string> profile;        ///< empty text: none
  bool is_broker_by_flag = false;            ///< --broker, not only the environment
  bool is_host_by_flag = false;              ///< --host or --port
  bool is_login_open = false;                ///< a user by flag, and nothing said of a password
  std::vector<std::string_view> configured;  ///< the keys that the configuration has set
};

/// The help groups of global options; a command's own help leaves them out.
[[nodiscard]] bool IsGlobalGroup(std::string_view group);

/// Adds them to an App; `options` must outlive its parsing.
void DeclareGlobalOptions(OptionSet& set, GlobalOptions& options);

/// Once they are parsed: sets what neither flag nor environment gave. Errors: ErrorKind::kUsage (a
/// login where everybody can read it).
[[nodiscard]] Status ApplyConfig(const config::Config& config, OptionSet& set,
                                 GlobalOptions& options);

/// All that is wrong in the configuration that the options name, for whichever command. `config` has
/// what is right.
[[nodiscard]] config::Mistakes CheckConfiguration(const GlobalOptions& options,
                                                  config::Config& config);

/// What a running command needs of the outer world.
struct Context {
  const GlobalOptions& options;
  Output& output;
  const config::Config& config;
};

/// Which brokers are named; the default one when none is. Errors: ErrorKind::kUsage.
[[nodiscard]] Result<std::vector<mqtt::BrokerUrl>> ParseBrokers(const GlobalOptions& options);

/// Brokers, credentials and TLS as the options, the environment and files say. May prompt for a
/// password. Errors: ErrorKind::kUsage (also a profile whose broker somebody contradicts, and a
/// login that is another broker's), kLedger (a password file that cannot be read).
[[nodiscard]] Result<mqtt::ConnectOptions> MakeConnectOptions(const Context& context);
/// The same; `log` is told what is careless about them.
[[nodiscard]] Result<mqtt::ConnectOptions> MakeConnectOptions(const Context& context,
                                                              app::Log& log);

/// The file or the database that the options name. Errors: ErrorKind::kUsage (a URL that is none of
/// PostgreSQL's, or holds a password), kLedger.
[[nodiscard]] Result<std::unique_ptr<ledger::Ledger>> OpenLedger(const Context& context,
                                                                 ledger::OpenMode mode);

}  // namespace fleetpub::cli
