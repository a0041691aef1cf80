#include "cli/options/global_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <tuple>

#include "base/text.h"
#include "base/time.h"
#include "cli/broker_guard.h"
#include "cli/options/identity.h"
#include "cli/options/password.h"
#include "cli/parser/option_set.h"
#include "config/config_settings.h"
#include "ledger/postgres/postgres_ledger.h"
#include "ledger/postgres/postgres_url.h"
#include "ledger/sqlite/sqlite_ledger.h"

namespace fleetpub::cli {
namespace {

constexpr const char* kBrokerGroup = "Broker";
constexpr const char* kTls = "TLS";
constexpr const char* kOutput = "Output";
constexpr const char* kFiles = "Files";
constexpr const char* kConfig = "Configuration";

// The key of a setting is its option's long name: `-i,--client-id` → client_id.
std::string_view KeyOf(std::string_view names) {
  const std::string_view name = names.substr(names.find("--") + 2);
  for (const std::string_view key : {"host", "port"}) {
    if (key == name) return key;  // no settings, but shown with them
  }
  const auto setting = std::find_if(
      config::Settings().begin(), config::Settings().end(), [&](const config::Setting& candidate) {
        return std::equal(name.begin(), name.end(), candidate.key.begin(), candidate.key.end(),
                          [](char a, char b) { return a == b || (a == '-' && b == '_'); });
      });
  assert(setting != config::Settings().end());
  return setting->key;
}

void DeclareBroker(OptionSet& set, GlobalOptions& o) {
  ConfigBindings& bindings = set.bindings();
  bindings.Bind("broker",
                set.AddOption("-b,--broker", o.brokers,
                              "Broker as URL, mqtt|mqtts|ws|wss://[user@]host[:port]; repeat for "
                              "failover [mqtt://localhost:1883]")
                    .Type("URL")
                    .Variable("FLEETPUB_BROKER")
                    .OneValueEach()
                    .Group(kBrokerGroup),
                &o.brokers);
  const auto add = [&](const char* names, std::string& value, const char* type, const char* env,
                       const char* help) {
    const Option option = set.AddOption(names, value, help).Type(type).Group(kBrokerGroup);
    if (*env != '\0') option.Variable(env);
    bindings.Bind(KeyOf(names), option, &value);
  };
  add("--host", o.host, "NAME", "FLEETPUB_HOST", "Broker's host, instead of a URL");
  add("-p,--port", o.port, "PORT", "FLEETPUB_PORT", "Broker's port, with --host [1883]");
  add("-u,--username", o.username, "USER", "FLEETPUB_USERNAME", "User name to log in with");
  add("--password-file", o.password_file, "FILE", "FLEETPUB_PASSWORD_FILE",
      "File whose first line is the password (or set FLEETPUB_PASSWORD)");
  set.AddFlag("--ask-password", o.ask_password, "Ask for the password on the terminal")
      .Group(kBrokerGroup);
  add("-i,--client-id", o.client_id, "ID", "FLEETPUB_CLIENT_ID", "MQTT client id [a random one]");
  add("-k,--keep-alive", o.keep_alive, "S", "", "MQTT keep-alive in seconds [60]");
  add("-V,--mqtt-version", o.mqtt_version, "V", "FLEETPUB_MQTT_VERSION", "3.1.1 or 5 [3.1.1]");
  add("--connect-timeout", o.connect_timeout, "TIME", "FLEETPUB_CONNECT_TIMEOUT",
      "To connect, and for the broker to acknowledge at QoS 1 and 2 [10s]");
  add("--proxy", o.proxy, "URL", "FLEETPUB_PROXY",
      "HTTP proxy; the variables http_proxy and https_proxy are ignored");
}

void DeclareProperties(OptionSet& set, GlobalOptions& o) {
  set.bindings().Bind("user_property",
                      set.AddOption("--user-property", o.user_properties,
                                    "MQTT 5: a property to send with each message; repeatable")
                          .Type("NAME=VALUE")
                          .OneValueEach()
                          .Group(kBrokerGroup),
                      &o.user_properties);
  set.bindings().Bind(
      "message_expiry",
      set.AddOption(
             "--message-expiry", o.message_expiry,
             "MQTT 5: how long a broker may keep a message for a robot that is offline [no limit]")
          .Type("TIME")
          .Variable("FLEETPUB_MESSAGE_EXPIRY")
          .Group(kBrokerGroup),
      &o.message_expiry);
}

void DeclareTls(OptionSet& set, GlobalOptions& o) {
  const auto add = [&](const char* names, std::string& value, const char* type, const char* env,
                       const char* help) {
    set.bindings().Bind(KeyOf(names),
                        set.AddOption(names, value, help).Type(type).Variable(env).Group(kTls),
                        &value);
  };
  add("--cafile", o.ca_file, "FILE", "FLEETPUB_CAFILE", "Authorities to trust, PEM [the system's]");
  add("--capath", o.ca_path, "FOLDER", "FLEETPUB_CAPATH", "Folder of authorities to trust");
  add("--cert", o.cert_file, "FILE", "FLEETPUB_CERT", "Our own certificate, PEM");
  add("--key", o.key_file, "FILE", "FLEETPUB_KEY", "Its private key, PEM");
  add("--key-password-file", o.key_password_file, "FILE", "FLEETPUB_KEY_PASSWORD_FILE",
      "File whose first line is the key's password");
  add("--ciphers", o.ciphers, "LIST", "FLEETPUB_CIPHERS",
      "Ciphers to offer, as OpenSSL names them");
  set.bindings().Bind(
      "tls_alpn",
      set.AddOption("--tls-alpn", o.alpn, "Application protocol to offer; repeatable")
          .Type("NAME")
          .OneValueEach()
          .Group(kTls),
      &o.alpn);
  set.bindings().Bind(
      "insecure",
      set.AddFlag("--insecure", o.insecure,
                  "Do not verify the broker's certificate: anyone could be the broker")
          .Group(kTls),
      &o.insecure);
}

void DeclareOutput(OptionSet& set, GlobalOptions& o) {
  set.bindings().Bind(
      "output",
      set.AddOption("-o,--output", o.format, "text, or json: one object per line [text]")
          .Type("FORMAT")
          .Variable("FLEETPUB_OUTPUT")
          .Group(kOutput),
      &o.format);
  set.AddFlag("--quiet", o.quiet, "No result lines and no warnings; errors stay").Group(kOutput);
  set.AddFlag("-v,--verbose", o.verbose, "Tell what is done, and the details of errors")
      .Group(kOutput);
  set.AddFlag("--debug", o.debug, "Show the MQTT conversation, never a secret").Group(kOutput);
}

void DeclareFiles(OptionSet& set, GlobalOptions& o) {
  ConfigBindings& bindings = set.bindings();
  bindings.Bind(
      "ledger",
      set.AddOption(
             "--ledger", o.ledger,
             "Header ids and history: a file, or postgresql://... [see the manual, \"Files\"]")
          .Type("PLACE")
          .Variable("FLEETPUB_LEDGER")
          .Group(kFiles),
      &o.ledger);
  bindings.Bind(
      "no_history",
      set.AddFlag("--no-history", o.no_history, "Keep header ids only, no row of what was sent")
          .Group(kFiles),
      &o.no_history);
  bindings.Bind("header_id_start", Option(), &o.header_id_start);
  bindings.Bind("schema_dir",
                set.AddOption("--schema-dir", o.schema_directory,
                              "Schemas that stand before the built-in ones")
                    .Type("FOLDER")
                    .Variable("FLEETPUB_SCHEMA_DIR")
                    .Group(kFiles),
                &o.schema_directory);
}

void DeclareConfig(OptionSet& set, GlobalOptions& o) {
  set.AddOption("--config", o.config_file,
                "Configuration, instead of the host's and the user's file")
      .Type("FILE")
      .Variable("FLEETPUB_CONFIG")
      .Group(kConfig);
  set.AddOption("--profile", o.profile, "Its settings for one site")
      .Type("NAME")
      .Variable("FLEETPUB_PROFILE")
      .Group(kConfig);
}

bool HasUserName(const std::string& broker) { return broker.find('@') != std::string::npos; }

// What a flag says of the broker goes before what the environment says of it in the other form.
void PreferFlags(const OptionSet& set, GlobalOptions& o) {
  const bool by_url = set.IsByFlag("--broker");
  if (set.IsByFlag("--host") && !by_url) o.brokers.clear();
  const bool by_host = set.IsByFlag("--host") || set.IsByFlag("--port");
  if (by_url && !by_host) {
    o.host.clear();
    o.port.clear();
  }
  o.is_broker_by_flag = by_url;
  o.is_host_by_flag = by_host;
}

// Everybody on the machine can read the arguments of a process.
Status CheckProxy(const OptionSet& set, const GlobalOptions& o) {
  if (!set.IsByFlag("--proxy") || o.proxy.find('@') == std::string::npos) return {};
  return Fail(ErrorKind::kUsage,
              "a proxy's login does not stand in the arguments, which every user of this machine "
              "can read: set FLEETPUB_PROXY");
}

Result<int> ParseWhole(std::string_view text, int least, int most, std::string_view option) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) {
    return value;
  }
  return Fail(ErrorKind::kUsage, fmt::format("{} takes a whole number from {} to {}, not '{}'",
                                             option, least, most, base::Printable(text)));
}

// Who names an authority expects to be encrypted. A configuration may do so for other brokers.
Status CheckEncryption(const Context& context, std::span<const mqtt::BrokerUrl> brokers) {
  const GlobalOptions& o = context.options;
  const std::array<std::tuple<std::string_view, const std::string*, std::string_view>, 3> given = {
      {{"cafile", &o.ca_file, "--cafile"},
       {"capath", &o.ca_path, "--capath"},
       {"cert", &o.cert_file, "--cert"}}};
  for (const auto& [key, value, option] : given) {
    if (value->empty() || context.config.Find(key) != nullptr) continue;
    for (const mqtt::BrokerUrl& broker : brokers) {
      if (broker.UsesTls()) continue;
      return Fail(ErrorKind::kUsage,
                  fmt::format("{0} is for TLS, and {1} is not encrypted: name the broker with "
                              "--broker mqtts://HOST[:PORT], or leave {0} out",
                              option, broker.ToString()));
    }
  }
  return {};
}

Result<mqtt::TlsOptions> MakeTlsOptions(const Context& context) {
  const GlobalOptions& o = context.options;
  mqtt::TlsOptions tls{.ca_file = o.ca_file,
                       .ca_path = o.ca_path,
                       .cert_file = o.cert_file,
                       .key_file = o.key_file,
                       .key_password = std::nullopt,
                       .ciphers = o.ciphers,
                       .alpn = o.alpn,
                       .verify = !o.insecure};
  if (!o.key_password_file.empty()) {
    auto password = ReadPasswordFile(o.key_password_file, context.output);
    if (!password) return Fail(std::move(password.error()));
    tls.key_password = std::move(*password);
  }
  if (o.insecure) {
    context.output.Warn(
        "--insecure: the broker's certificate is not verified: anyone could be "
        "the broker, read the login and command the robots");
  }
  return tls;
}

Result<mqtt::ProtocolVersion> MqttVersionOf(std::string_view text) {
  if (text == "3.1.1" || text == "311" || text == "4") return mqtt::ProtocolVersion::k311;
  if (text == "5" || text == "5.0") return mqtt::ProtocolVersion::k5;
  return Fail(ErrorKind::kUsage,
              fmt::format("--mqtt-version takes 3.1.1 or 5, not '{}'", base::Printable(text)));
}

Result<std::pair<std::string, std::string>> ParseUserProperty(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--user-property takes NAME=VALUE, not '{}'", base::Printable(text)));
  }
  // MQTT 5 §1.5.4: UTF-8 without NUL, 65,535 bytes at most.
  constexpr std::size_t kLongest = 65'535;
  if (!base::IsUtf8(text) || equals > kLongest || text.size() - equals - 1 > kLongest) {
    return Fail(ErrorKind::kUsage,
                "--user-property takes UTF-8, of at most 65,535 bytes for the name and as many for "
                "the value");
  }
  return std::pair(text.substr(0, equals), text.substr(equals + 1));
}

Result<std::chrono::seconds> ExpiryOf(std::string_view text) {
  const auto time = base::ParseDuration(text);
  if (!time) return Fail(time.error());
  const auto expiry = std::chrono::ceil<std::chrono::seconds>(*time);
  if (expiry.count() >= 1 && expiry.count() <= UINT32_MAX) return expiry;
  return Fail(ErrorKind::kUsage, "--message-expiry takes a time of at least a second");
}

Result<mqtt::PublishProperties> ParseProperties(const GlobalOptions& o,
                                                mqtt::ProtocolVersion version) {
  mqtt::PublishProperties properties;
  for (const std::string& text : o.user_properties) {
    auto property = ParseUserProperty(text);
    if (!property) return Fail(std::move(property.error()));
    properties.user.push_back(std::move(*property));
  }
  if (!o.message_expiry.empty()) {
    const auto expiry = ExpiryOf(o.message_expiry);
    if (!expiry) return Fail(expiry.error());
    properties.expiry = *expiry;
  }
  const bool any = properties.expiry || !properties.user.empty();
  if (any && version != mqtt::ProtocolVersion::k5) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} needs MQTT 5, and 3.1.1 is to be spoken: add --mqtt-version 5",
                            properties.expiry ? "--message-expiry" : "--user-property"));
  }
  return properties;
}

}  // namespace

bool IsGlobalGroup(std::string_view group) {
  return group == kBrokerGroup || group == kTls || group == kOutput || group == kFiles ||
         group == kConfig;
}

void DeclareGlobalOptions(OptionSet& set, GlobalOptions& options) {
  DeclareBroker(set, options);
  DeclareProperties(set, options);
  DeclareTls(set, options);
  DeclareOutput(set, options);
  DeclareFiles(set, options);
  DeclareConfig(set, options);
}

Status ApplyConfig(const config::Config& config, OptionSet& set, GlobalOptions& options) {
  if (auto ok = CheckProxy(set, options); !ok) return ok;
  ForgetVariable("FLEETPUB_PROXY");
  PreferFlags(set, options);
  std::vector<std::string_view> except;
  if (!options.host.empty() || !options.port.empty()) except.emplace_back("broker");
  if (!options.brokers.empty()) except.insert(except.end(), {"host", "port"});
  if (options.ask_password || HasPasswordInEnvironment()) except.emplace_back("password_file");
  if (!options.brokers.empty() &&
      std::all_of(options.brokers.begin(), options.brokers.end(), HasUserName)) {
    except.emplace_back("username");
  }
  options.configured = set.bindings().Apply(config, std::move(except));
  return {};
}

Result<std::vector<mqtt::BrokerUrl>> ParseBrokers(const GlobalOptions& o) {
  std::vector<mqtt::BrokerUrl> brokers;
  const bool by_host = !o.host.empty() || !o.port.empty();
  if (by_host && !o.brokers.empty()) {
    return Fail(ErrorKind::kUsage,
                "say where the broker is with --broker (FLEETPUB_BROKER) or with --host and --port "
                "(FLEETPUB_HOST, FLEETPUB_PORT), not with both");
  }
  if (by_host) {
    mqtt::BrokerUrl broker;
    broker.host = o.host.empty() ? "localhost" : o.host;
    const auto port = ParseWhole(o.port.empty() ? "1883" : o.port, 1, 65'535, "--port");
    if (!port) return Fail(port.error());
    broker.port = static_cast<std::uint16_t>(*port);
    brokers.push_back(broker);
    return brokers;
  }
  for (const std::string& text : o.brokers) {
    auto broker = mqtt::ParseBrokerUrl(text);
    if (!broker) return Fail(std::move(broker.error()));
    brokers.push_back(std::move(*broker));
  }
  if (brokers.empty()) brokers.push_back({.host = "localhost"});
  return brokers;
}

Result<mqtt::ConnectOptions> MakeConnectOptions(const Context& context) {
  const GlobalOptions& o = context.options;
  auto brokers = ParseBrokers(o);
  if (!brokers) return Fail(std::move(brokers.error()));
  if (auto ok = CheckSite(context, *brokers); !ok) return Fail(std::move(ok.error()));
  if (auto ok = CheckLogin(context, *brokers); !ok) return Fail(std::move(ok.error()));
  if (auto ok = CheckEncryption(context, *brokers); !ok) return Fail(std::move(ok.error()));
  const auto version = MqttVersionOf(o.mqtt_version);
  if (!version) return Fail(version.error());
  const auto keep_alive = ParseWhole(o.keep_alive, 0, 65'535, "--keep-alive");
  if (!keep_alive) return Fail(keep_alive.error());
  const auto timeout = base::ParseDuration(o.connect_timeout);
  if (!timeout) return Fail(timeout.error());
  auto properties = ParseProperties(o, *version);
  if (!properties) return Fail(std::move(properties.error()));
  auto tls = MakeTlsOptions(context);
  if (!tls) return Fail(std::move(tls.error()));
  auto password = FindPassword(context);
  if (!password) return Fail(std::move(password.error()));

  mqtt::ConnectOptions connect;
  connect.brokers = std::move(*brokers);
  connect.client_id = o.client_id;
  connect.username = o.username;
  connect.password = std::move(*password);
  connect.keep_alive = std::chrono::seconds(*keep_alive);
  connect.version = *version;
  connect.properties = std::move(*properties);
  connect.connect_timeout = *timeout;
  connect.tls = std::move(*tls);
  connect.proxy = o.proxy;
  if (connect.password && connect.username.empty() && connect.brokers.front().username.empty()) {
    return Fail(ErrorKind::kUsage, "a password needs a user name: add --username");
  }
  if (o.debug) {
    connect.trace = [&output = context.output](std::string_view line) { output.Trace(line); };
  }
  return connect;
}

namespace {

void Describe(const Context& context, ledger::Options& options) {
  options.keep_history = !context.options.no_history;
  options.user = UserName();
  options.host = HostName();
  options.profile = context.config.profile;
  if (context.options.header_id_start == "epoch") options.start = ledger::HeaderIdStart::kEpoch;
}

Result<std::unique_ptr<ledger::Ledger>> OpenPostgres(const Context& context,
                                                     ledger::OpenMode mode) {
  if (auto right = ledger::CheckPostgresUrl(context.options.ledger); !right) {
    return Fail(std::move(right.error()));
  }
  ledger::PostgresOptions options;
  Describe(context, options);
  options.url = context.options.ledger;
  const auto timeout = base::ParseDuration(context.options.connect_timeout);
  if (!timeout) return Fail(timeout.error());
  options.connect_timeout = *timeout;
  auto password = FindLedgerPassword(context.output);
  if (!password) return Fail(std::move(password.error()));
  options.password = std::move(*password);
  return ledger::OpenPostgres(std::move(options), mode);
}

}  // namespace

Result<std::unique_ptr<ledger::Ledger>> OpenLedger(const Context& context, ledger::OpenMode mode) {
  if (ledger::IsUrl(context.options.ledger)) return OpenPostgres(context, mode);
  ledger::SqliteOptions options;
  Describe(context, options);
  options.path = context.options.ledger;
  if (options.path.empty()) {
    auto path = ledger::DefaultLedgerPath();
    if (!path) return Fail(std::move(path.error()));
    options.path = std::move(*path);
  }
  return ledger::OpenSqlite(std::move(options), mode);
}

}  // namespace fleetpub::cli
