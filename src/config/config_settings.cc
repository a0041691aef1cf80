#include "config/config_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/text.h"
#include "base/time.h"
#include "ledger/postgres/postgres_url.h"
#include "mqtt/broker_url.h"
#include "vda5050/model/robot_address.h"
#include "vda5050/model/version.h"

namespace fleetpub::config {
namespace {

std::string_view GetText(std::string_view word) { return word; }
template <class T>
std::string_view GetText(const base::Choice<T>& choice) {
  return choice.text;
}

template <const auto& kTable>
Status CheckOneOf(const std::string& value) {
  std::vector<std::string> known;
  for (const auto& each : kTable) {
    if (base::EqualsIgnoringCase(GetText(each), value)) return {};
    known.emplace_back(GetText(each));
  }
  return Fail(ErrorKind::kUsage,
              fmt::format("takes {}, not '{}'", base::Join(known, ", "), base::Printable(value)));
}

Status CheckBroker(const std::string& value) {
  if (auto url = mqtt::ParseBrokerUrl(value); !url) return Fail(std::move(url.error()));
  return {};
}

Status CheckArgument(const std::string& value) {
  if (value.find('\0') == std::string::npos) return {};
  return Fail(ErrorKind::kUsage, "no program takes an argument with a NUL in it");
}

Status CheckVda(const std::string& value) {
  if (value == "auto") return {};
  if (auto version = vda5050::ParseVersion(value); !version) return Fail(version.error());
  return {};
}

Status CheckInterface(const std::string& value) {
  return value.empty() ? Status() : vda5050::CheckInterface(value);
}

Status CheckTemplate(const std::string& value) {
  if (value.empty()) return {};
  const auto topic = vda5050::TopicFor({.topic_template = value}, vda5050::Version::k300,
                                       {"KIT", "0001"}, "state");
  return topic ? Status() : Fail(topic.error());
}

Status CheckDuration(const std::string& value) {
  if (auto time = base::ParseDuration(value); !time) return Fail(time.error());
  return {};
}

// The password would stand in a file that is shared and copied.
Status CheckProxy(const std::string& value) {
  if (value.find('@') == std::string::npos) return {};
  return Fail(ErrorKind::kUsage,
              "a proxy's login cannot be in a configuration file: set FLEETPUB_PROXY");
}

Status CheckLedger(const std::string& value) {
  return ledger::IsUrl(value) ? ledger::CheckPostgresUrl(value) : Status();
}

using enum SettingType;

constexpr auto kSettings = std::to_array<Setting>({
    {"broker", kTexts, "mqtt://localhost:1883", CheckBroker},
    {"username", kText, ""},
    {"password_file", kPath, ""},
    {kPasswordCommand, kCommand, "", CheckArgument},
    {"auth_method", kText, ""},
    {"auth_data_file", kPath, ""},
    {"client_id", kText, "a random one"},
    {"keep_alive", kWhole, "60"},
    {"mqtt_version", kTextOrWhole, "3.1.1", CheckOneOf<kMqttVersions>},
    {"user_property", kTexts, ""},
    {"message_expiry", kText, "", CheckDuration},
    {"connect_timeout", kText, "10s", CheckDuration},
    {"proxy", kText, "", CheckProxy},
    {"cafile", kPath, "the system's"},
    {"capath", kPath, ""},
    {"cert", kPath, ""},
    {"key", kPath, ""},
    {"key_password_file", kPath, ""},
    {"ciphers", kText, "OpenSSL's"},
    {"tls_server_name", kText, "the broker's host"},
    {"tls_alpn", kTexts, ""},
    {"insecure", kFlag, "false"},
    {"output", kText, "text", CheckOneOf<kOutputs>},
    {"ledger", kPath, "see the manual, \"Files\"", CheckLedger},
    {"no_history", kFlag, "false"},
    {"header_id_start", kText, "zero", CheckOneOf<kHeaderIdStarts>},
    {"schema_dir", kPath, ""},
    {"layout", kPath, ""},
    {"qos", kWhole, "0", CheckOneOf<kQos>},
    {"tidy", kFlag, "false"},
    {"vda", kText, "auto", CheckVda},
    {"interface", kText, "uagv up to 2.x, vda5050 from 3.0", CheckInterface},
    {"topic_template", kText, "{interface}/{major}/{manufacturer}/{serial}/{topic}", CheckTemplate},
    {"soar_source", kText, "fleetpub"},
    {"soar_prefix", kText, "soar"},
});

constexpr auto kRobotSettings = std::to_array<Setting>({
    {"alias", kText, "", CheckTargetName},
    {"vda", kText, "", CheckVda},
    {"interface", kText, "", CheckInterface},
    {"topic_template", kText, "", CheckTemplate},
    {"actions_key", kText, "", CheckOneOf<kActionsKeys>},
    {"header_version", kText, ""},
    {"header_manufacturer", kText, ""},
    {"header_serial", kText, ""},
});

}  // namespace

std::span<const Setting> Settings() { return kSettings; }

std::span<const Setting> RobotSettings() { return kRobotSettings; }

Status CheckTargetName(const std::string& name) {
  constexpr std::string_view kRefused = "/+#$@*?,\"' ";
  if (!name.empty() && name.front() != '-' && name.find_first_of(kRefused) == std::string::npos &&
      base::Printable(name) == name) {
    return {};
  }
  return Fail(ErrorKind::kUsage,
              fmt::format("'{}' is not a name for a target: it must not be empty, begin with - or "
                          "contain a blank, a control character or one of / + # $ @ * ? , \" '",
                          base::Printable(name)));
}

}  // namespace fleetpub::config
