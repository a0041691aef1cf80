#include "cli/options/global_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <tuple>

#include "base/text.h"
#include "cli/broker_guard.h"
#include "cli/options/identity.h"
#include "cli/options/password.h"
#include "cli/parser/option_set.h"
#include "config/config_files.h"
#include "config/config_settings.h"
#include "ledger/postgres/postgres_ledger.h"
#include "ledger/postgres/postgres_url.h"
#include "ledger/sqlite/sqlite_ledger.h"
#include "soar/destination.h"

namespace fleetpub::cli {
namespace {

constexpr auto kDebug = std::to_array<std::string_view>({"topics", "full"});

constexpr const char* kBrokerGroup = "Broker";
constexpr const char* kTls = "TLS";
constexpr const char* kOutput = "Output";
constexpr const char* kFiles = "Files";
constexpr const char* kConfig = "Configuration";

// Beside those of the configuration, which is for all commands, what one command has.
constexpr auto kFormats = [] {
  std::array<std::string_view, config::kOutputs.size() + 1> formats{};
  *std::copy(config::kOutputs.begin(), config::kOutputs.end(), formats.begin()) = kOpenMetrics;
  return formats;
}();

constexpr auto kColors = std::to_array<std::string_view>({"auto", "always", "never"});

// The key of a setting is its option's long name: `-i,--client-id` → client_id.
std::string_view FindKey(std::string_view names) {
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

// A host name or an address as in a broker's URL, and nothing else.
bool IsServerName(const std::string& name) {
  const auto is_host_in = [&](const std::string& text) {
    const auto url = mqtt::ParseBrokerUrl(text);
    return url && base::EqualsIgnoringCase(url->host, name);
  };
  return name.empty() || is_host_in("mqtts://" + name) || is_host_in("mqtts://[" + name + "]");
}

// MQTT 5 §1.5.4: UTF-8 without NUL, 65,535 bytes at most.
bool IsUserProperty(const std::string& text) {
  constexpr std::size_t kLongest = 65'535;
  const std::size_t equals = text.find('=');
  return equals != 0 && equals != std::string::npos && base::IsUtf8(text) && equals <= kLongest &&
         text.size() - equals - 1 <= kLongest;
}

// MQTT 5 §3.3.2.3.3: four bytes of seconds.
bool IsExpiry(const std::string& text) {
  if (text.empty()) return true;
  const auto time = base::ParseDuration(text);
  return time && *time >= std::chrono::seconds(1) && *time <= std::chrono::seconds(UINT32_MAX);
}

// RFC 7301 §3.1: one byte counts those of a name.
bool IsProtocolName(const std::string& name) { return !name.empty() && name.size() <= 255; }

// Declares the options of one group, each under its setting's key.
struct Group {
  OptionSet& set;
  const char* name;

  template <class V>
  Option Add(const char* names, V&& value, const char* type, const char* help) const {
    return set.AddOption(names, std::forward<V>(value), help)
        .Type(type)
        .Group(name)
        .Key(FindKey(names));
  }
};

void DeclareBroker(OptionSet& set, GlobalOptions& o) {
  const Group group{set, kBrokerGroup};
  group
      .Add("-b,--broker", o.brokers, "URL",
           "Broker as URL, mqtt|mqtts|ws|wss://[user@]host[:port]; repeat for failover "
           "[mqtt://localhost:1883]")
      .Variable("FLEETPUB_BROKER")
      .OneValueEach();
  group.Add("--host", o.host, "NAME", "Broker's host, instead of a URL").Variable("FLEETPUB_HOST");
  group
      .Add("-p,--port", WholeNumber(o.port, 1, 65'535), "PORT", "Broker's port, with --host [1883]")
      .Variable("FLEETPUB_PORT");
  group.Add("-u,--username", o.username, "USER", "User name to log in with")
      .Variable("FLEETPUB_USERNAME");
  group
      .Add("--password-file", o.password_file, "FILE",
           "File whose first line is the password (or set FLEETPUB_PASSWORD)")
      .Variable("FLEETPUB_PASSWORD_FILE");
  set.AddSetting(config::kPasswordCommand, Text(o.password_command));
  set.AddFlag("--ask-password", o.ask_password, "Ask for the password on the terminal")
      .Group(kBrokerGroup);
  group
      .Add("--auth-method", o.auth_method, "NAME",
           "MQTT 5: enhanced authentication by this method, in one step")
      .Variable("FLEETPUB_AUTH_METHOD");
  group
      .Add("--auth-data-file", o.auth_data_file, "FILE",
           "File that holds this method's data, such as a token")
      .Variable("FLEETPUB_AUTH_DATA_FILE");
  group.Add("-i,--client-id", o.client_id, "ID", "MQTT client id [a random one]")
      .Variable("FLEETPUB_CLIENT_ID");
  group.Add("-k,--keep-alive", WholeNumber(o.keep_alive, 0, 65'535), "S",
            "MQTT keep-alive in seconds [60]");
  group.Add("-V,--mqtt-version", OneOf(o.mqtt_version, config::kMqttVersions), "V", "{} [3.1.1]")
      .Variable("FLEETPUB_MQTT_VERSION");
  group
      .Add("--connect-timeout", Duration(o.connect_timeout), "TIME",
           "To connect, and for the broker to acknowledge at QoS 1 and 2 [10s]")
      .Variable("FLEETPUB_CONNECT_TIMEOUT");
  group
      .Add("--proxy", o.proxy, "URL",
           "HTTP proxy; the variables http_proxy and https_proxy are ignored")
      .Variable("FLEETPUB_PROXY");
  group
      .Add("--user-property",
           Only(Text(o.user_properties), IsUserProperty,
                "NAME=VALUE in UTF-8, at most 65,535 bytes each"),
           "NAME=VALUE", "MQTT 5: a property to send with each message; repeatable")
      .OneValueEach();
  group
      .Add("--message-expiry",
           Only(Duration(o.message_expiry), IsExpiry,
                "a duration from 1s to 49710d, such as 30s or 5m"),
           "TIME",
           "MQTT 5: how long a broker may keep a message for a robot that is offline [no limit]")
      .Variable("FLEETPUB_MESSAGE_EXPIRY");
}

void DeclareTls(OptionSet& set, GlobalOptions& o) {
  const Group group{set, kTls};
  const auto add = [&](const char* names, std::string& value, const char* type, const char* env,
                       const char* help) { group.Add(names, value, type, help).Variable(env); };
  add("--cafile", o.ca_file, "FILE", "FLEETPUB_CAFILE", "Authorities to trust, PEM [the system's]");
  add("--capath", o.ca_path, "FOLDER", "FLEETPUB_CAPATH", "Folder of authorities to trust");
  add("--cert", o.cert_file, "FILE", "FLEETPUB_CERT", "Our own certificate, PEM");
  add("--key", o.key_file, "FILE", "FLEETPUB_KEY", "Its private key, PEM");
  add("--key-password-file", o.key_password_file, "FILE", "FLEETPUB_KEY_PASSWORD_FILE",
      "File whose first line is the key's password");
  add("--ciphers", o.ciphers, "LIST", "FLEETPUB_CIPHERS",
      "Ciphers to offer, as OpenSSL names them");
  group
      .Add("--tls-server-name",
           Only(Text(o.tls_server_name), IsServerName,
                "a host name as in the certificate, such as broker.example"),
           "NAME", "Host name that the certificate must be for [the broker's]")
      .Variable("FLEETPUB_TLS_SERVER_NAME");
  group
      .Add("--tls-alpn", Only(Text(o.alpn), IsProtocolName, "a name of 1 to 255 bytes"), "NAME",
           "Application protocol to offer; repeatable")
      .OneValueEach();
  set.AddFlag("--insecure", o.insecure,
              "Do not verify the broker's certificate: anyone could be the broker")
      .Group(kTls)
      .Key("insecure");
}

// One of the words, or a text of one's own.
ValueKind OutputFormat(std::string& format) {
  ValueKind kind = OneOf(format, kFormats);
  kind.store = [&format, word = kind.store](const std::vector<std::string>& texts) {
    if (!texts.front().starts_with(kTemplatePrefix)) return word(texts);
    format = texts.front();
    return true;
  };
  return kind;
}

void DeclareOutput(OptionSet& set, GlobalOptions& o) {
  Group{set, kOutput}
      .Add(
          "-o,--output", OutputFormat(o.format), "FORMAT",
          "{} (of fleet), a row or object per result, or template=TEXT with names in braces [text]")
      .Variable("FLEETPUB_OUTPUT");
  set.AddOption("--fields", o.fields, "Only these members of each object: target,actions.0.type")
      .Type("NAMES")
      .Group(kOutput);
  set.AddFlag("--quiet", o.quiet, "No result lines and no warnings; errors stay").Group(kOutput);
  set.AddFlag("-v,--verbose", o.verbose, "Tell what is done, and the details of errors")
      .Group(kOutput);
  set.AddFlag("--debug", OneOf(o.debug, kDebug), std::string(kDebug.front()),
              "Show the MQTT conversation, never a password; --debug=full with the messages")
      .Group(kOutput);
  set.AddOption("--color", OneOf(o.color, kColors),
                "{}; auto: on a terminal without NO_COLOR [auto]")
      .Type("WHEN")
      .Group(kOutput);
}

void DeclareFiles(OptionSet& set, GlobalOptions& o) {
  const Group group{set, kFiles};
  group
      .Add("--ledger", o.ledger, "PLACE",
           "Header ids and history: a file, or postgresql://... [see the manual, \"Files\"]")
      .Variable("FLEETPUB_LEDGER");
  set.AddFlag("--no-history", o.no_history, "Keep header ids only, no row of what was sent")
      .Group(kFiles)
      .Key("no_history");
  set.AddSetting("header_id_start", OneOf(o.header_id_start, config::kHeaderIdStarts));
  group
      .Add("--schema-dir", o.schema_directory, "FOLDER",
           "Schemas that stand before the built-in ones")
      .Variable("FLEETPUB_SCHEMA_DIR");
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
  if (set.IsByFlag("--host") && !by_url) {
    o.brokers.clear();
    set.Find("--broker").Forget();
  }
  const bool by_host = set.IsByFlag("--host") || set.IsByFlag("--port");
  if (by_url && !by_host) {
    o.host.clear();
    o.port.reset();
    set.Find("--host").Forget();
    set.Find("--port").Forget();
  }
  o.is_broker_by_flag = by_url;
  o.is_host_by_flag = by_host;
  o.is_login_open = set.IsByFlag("--username") && !set.Find("--password-file").IsGiven() &&
                    !set.Find("--cert").IsGiven();
}

// What goes before the configuration's password, and which of its two ways holds: a profile's goes
// before one outside of profiles, and no table has both.
void ChoosePassword(const config::Config& config, const OptionSet& set, const GlobalOptions& o,
                    std::vector<std::string_view>& except) {
  constexpr std::string_view kFile = "password_file";
  if (o.ask_password || HasPasswordInEnvironment()) {
    except.insert(except.end(), {kFile, config::kPasswordCommand});
    return;
  }
  const config::ConfigValue* const file = config.Find(kFile);
  const config::ConfigValue* const command = config.Find(config::kPasswordCommand);
  const bool is_file = set.Find("--password-file").IsGiven() || command == nullptr ||
                       (file != nullptr && !file->profile.empty());
  except.push_back(is_file ? config::kPasswordCommand : kFile);
}

// Everybody on the machine can read the arguments of a process.
Status CheckProxy(const OptionSet& set, const GlobalOptions& o) {
  if (!set.IsByFlag("--proxy") || o.proxy.find('@') == std::string::npos) return {};
  return Fail(ErrorKind::kUsage,
              "a proxy's login does not belong in the arguments, which every user of this machine "
              "can read: set FLEETPUB_PROXY");
}

// Who names an authority expects to be encrypted. A configuration may do so for other brokers.
Status CheckEncryption(const Context& context, std::span<const mqtt::BrokerUrl> brokers) {
  const GlobalOptions& o = context.options;
  const std::array<std::tuple<std::string_view, const std::string*, std::string_view>, 4> given = {
      {{"cafile", &o.ca_file, "--cafile"},
       {"capath", &o.ca_path, "--capath"},
       {"cert", &o.cert_file, "--cert"},
       {"tls_server_name", &o.tls_server_name, "--tls-server-name"}}};
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

Result<mqtt::TlsOptions> MakeTlsOptions(const Context& context, app::Log& log) {
  const GlobalOptions& o = context.options;
  mqtt::TlsOptions tls{.ca_file = o.ca_file,
                       .ca_path = o.ca_path,
                       .cert_file = o.cert_file,
                       .key_file = o.key_file,
                       .key_password = std::nullopt,
                       .ciphers = o.ciphers,
                       .alpn = o.alpn,
                       .server_name = o.tls_server_name,
                       .verify = !o.insecure};
  if (!o.key_password_file.empty()) {
    auto password = ReadPasswordFile(o.key_password_file, log);
    if (!password) return Fail(std::move(password.error()));
    tls.key_password = std::move(*password);
  }
  if (o.insecure) {
    log.Warn(
        "--insecure: the broker's certificate is not verified: anyone could be "
        "the broker, read the login and command the robots");
  }
  return tls;
}

Result<mqtt::PublishProperties> ParseProperties(const GlobalOptions& o) {
  mqtt::PublishProperties properties;
  for (const std::string& text : o.user_properties) {
    const std::size_t equals = text.find('=');
    properties.user.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  if (o.message_expiry) {
    properties.expiry = std::chrono::ceil<std::chrono::seconds>(*o.message_expiry);
  }
  const bool any = properties.expiry || !properties.user.empty();
  if (any && o.mqtt_version != mqtt::ProtocolVersion::k5) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} needs MQTT 5: add --mqtt-version 5",
                            properties.expiry ? "--message-expiry" : "--user-property"));
  }
  return properties;
}

// The data as a tool writes it into a file: without the end of its last line.
Result<std::optional<mqtt::Authentication>> ReadAuthentication(const Context& context,
                                                               app::Log& log) {
  const GlobalOptions& o = context.options;
  if (o.auth_method.empty() && o.auth_data_file.empty()) {
    return std::optional<mqtt::Authentication>();
  }
  mqtt::Authentication authentication{.method = o.auth_method, .data = std::nullopt};
  if (!o.auth_data_file.empty()) {
    auto data = ReadSecretFile(o.auth_data_file, log);
    if (!data) return Fail(std::move(data.error()));
    if (data->ends_with('\n')) data->pop_back();
    if (data->ends_with('\r')) data->pop_back();
    authentication.data = *std::move(data);
  }
  return authentication;
}

// Who was refused, as an error says it; never a secret.
std::string DescribeLogin(const GlobalOptions& o, const FoundPassword& password) {
  std::string login = fmt::format(
      "{} and {}", o.username.empty() ? "no user name" : "user " + base::Printable(o.username),
      base::Printable(password.source));
  if (o.auth_method.empty()) return login;
  login += fmt::format(", method {}", base::Printable(o.auth_method));
  if (o.auth_data_file.empty()) return login;
  return login + fmt::format(" with the data of {}", base::Printable(o.auth_data_file));
}

}  // namespace

bool IsGlobalGroup(std::string_view group) {
  return group == kBrokerGroup || group == kTls || group == kOutput || group == kFiles ||
         group == kConfig;
}

void DeclareGlobalOptions(OptionSet& set, GlobalOptions& options) {
  DeclareBroker(set, options);
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
  if (!options.host.empty() || options.port) except.emplace_back("broker");
  if (!options.brokers.empty()) except.insert(except.end(), {"host", "port"});
  ChoosePassword(config, set, options, except);
  if (!options.brokers.empty() &&
      std::all_of(options.brokers.begin(), options.brokers.end(), HasUserName)) {
    except.emplace_back("username");
  }
  auto configured = set.Configure(config, std::move(except));
  if (!configured) return Fail(std::move(configured.error()));
  options.configured = *std::move(configured);
  return {};
}

config::Mistakes CheckConfiguration(const GlobalOptions& options, config::Config& config) {
  GlobalOptions checked;
  std::string prefix;
  OptionSet set(OptionSet::Extent::kAll, {});
  DeclareGlobalOptions(set, checked);
  const auto is_prefix = [](const std::string& text) {
    return soar::ParsePrefix(text).has_value();
  };
  // What only the options of other commands know.
  set.AddSetting("soar_prefix", Only(Text(prefix), is_prefix, "topic levels, such as soar"));
  return config::CheckConfig(
      options.config_file, options.profile,
      [&](std::string_view key, const std::vector<std::string>& texts) {
        return set.Check(key, texts);
      },
      config);
}

Result<std::vector<mqtt::BrokerUrl>> ParseBrokers(const GlobalOptions& o) {
  std::vector<mqtt::BrokerUrl> brokers;
  const bool by_host = !o.host.empty() || o.port;
  if (by_host && !o.brokers.empty()) {
    return Fail(ErrorKind::kUsage,
                "name the broker with --broker (FLEETPUB_BROKER) or with --host and --port "
                "(FLEETPUB_HOST, FLEETPUB_PORT), not with both");
  }
  if (by_host) {
    mqtt::BrokerUrl broker;
    broker.host = o.host.empty() ? "localhost" : o.host;
    broker.port = o.port.value_or(1883);
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
  return MakeConnectOptions(context, context.output);
}

Result<mqtt::ConnectOptions> MakeConnectOptions(const Context& context, app::Log& log) {
  const GlobalOptions& o = context.options;
  auto brokers = ParseBrokers(o);
  if (!brokers) return Fail(std::move(brokers.error()));
  if (auto ok = CheckSite(context, *brokers); !ok) return Fail(std::move(ok.error()));
  if (auto ok = CheckLogin(context, *brokers); !ok) return Fail(std::move(ok.error()));
  if (auto ok = CheckEncryption(context, *brokers); !ok) return Fail(std::move(ok.error()));
  auto properties = ParseProperties(o);
  if (!properties) return Fail(std::move(properties.error()));
  auto tls = MakeTlsOptions(context, log);
  if (!tls) return Fail(std::move(tls.error()));
  auto authentication = ReadAuthentication(context, log);
  if (!authentication) return Fail(std::move(authentication.error()));
  auto password = FindPassword(context, log);
  if (!password) return Fail(std::move(password.error()));

  mqtt::ConnectOptions connect;
  connect.brokers = std::move(*brokers);
  connect.client_id = o.client_id;
  connect.username = o.username;
  connect.password = std::move(password->text);
  connect.authentication = *std::move(authentication);
  connect.login = DescribeLogin(o, *password);
  connect.keep_alive = std::chrono::seconds(o.keep_alive);
  connect.version = o.mqtt_version;
  connect.properties = std::move(*properties);
  connect.connect_timeout = o.connect_timeout;
  connect.tls = std::move(*tls);
  connect.proxy = o.proxy;
  if (o.username.empty() && !connect.brokers.front().username.empty()) {
    connect.login.clear();  // each URL has its own
  }
  if (connect.password && connect.username.empty() && connect.brokers.front().username.empty()) {
    return Fail(ErrorKind::kUsage, "a password needs a user name: add --username");
  }
  if (!o.debug.empty()) {
    connect.trace_payloads = o.debug == "full";
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
  options.start = context.options.header_id_start;
}

Result<std::unique_ptr<ledger::Ledger>> OpenPostgres(const Context& context,
                                                     ledger::OpenMode mode) {
  if (auto right = ledger::CheckPostgresUrl(context.options.ledger); !right) {
    return Fail(std::move(right.error()));
  }
  ledger::PostgresOptions options;
  Describe(context, options);
  options.url = context.options.ledger;
  options.connect_timeout = context.options.connect_timeout;
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
