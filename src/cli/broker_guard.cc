#include "cli/broker_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/text.h"
#include "config/config_settings.h"

namespace fleetpub::cli {
namespace {

using Texts = std::vector<std::string>;

void AddBrokers(const config::ConfigSection& section, Texts& texts) {
  const auto found = section.find("broker");
  if (found == section.end()) return;
  texts.insert(texts.end(), found->second.texts.begin(), found->second.texts.end());
}

// For whom a setting of the configuration is written; empty: no broker is named.
Texts ListOwners(const config::ConfigValue& value, const config::Config& config) {
  Texts texts;
  if (!value.profile.empty()) {
    AddBrokers(config.profiles.find(value.profile)->second, texts);
    if (texts.empty()) AddBrokers(config.settings, texts);
    return texts;
  }
  AddBrokers(config.settings, texts);
  for (const auto& [name, section] : config.profiles) AddBrokers(section, texts);
  return texts;
}

bool IsSameBroker(const mqtt::BrokerUrl& a, const mqtt::BrokerUrl& b) {
  return a.scheme == b.scheme && a.port == b.port && a.path == b.path &&
         base::EqualsIgnoringCase(a.host, b.host);
}

// The first that is none of these; null: all are.
const mqtt::BrokerUrl* FindStranger(std::span<const mqtt::BrokerUrl> brokers, const Texts& known) {
  const auto is_known = [&](const mqtt::BrokerUrl& broker) {
    return std::any_of(known.begin(), known.end(), [&](const std::string& text) {
      const auto url = mqtt::ParseBrokerUrl(text);
      return url && IsSameBroker(*url, broker);
    });
  };
  const auto stranger = std::find_if_not(brokers.begin(), brokers.end(), is_known);
  return stranger == brokers.end() ? nullptr : &*stranger;
}

std::string_view WhoNamesTheBroker(const GlobalOptions& o) {
  if (!o.brokers.empty()) return "FLEETPUB_BROKER names";
  return o.is_host_by_flag ? "--host and --port name" : "FLEETPUB_HOST or FLEETPUB_PORT names";
}

// What is for one broker, and how to have it for another.
struct LoginSetting {
  std::string_view key;
  std::string_view way_out;
  bool is_for_tls = false;
};
constexpr std::string_view kOwnPassword =
    "give that one a login of its own with --username and --password-file ('' for none), or choose "
    "its --profile";
constexpr std::string_view kOwnMethod =
    "give that one its own --auth-method and --auth-data-file ('' for none), or choose its "
    "--profile";
constexpr std::string_view kOwnCertificate =
    "give that one its own --cert, --key and --key-password-file ('' for none), or choose its "
    "--profile";
constexpr LoginSetting kLogin[] = {
    {"username", kOwnPassword},
    {"password_file", kOwnPassword},
    {config::kPasswordCommand, kOwnPassword},
    {"auth_method", kOwnMethod},
    {"auth_data_file", kOwnMethod},
    {"cert", kOwnCertificate, true},
    {"key", kOwnCertificate, true},
    {"key_password_file", kOwnCertificate, true},
    {"insecure", "add --insecure if anyone may be that one", true},
};

}  // namespace

Status CheckSite(const Context& context, std::span<const mqtt::BrokerUrl> brokers) {
  const GlobalOptions& o = context.options;
  const std::string& profile = context.config.profile;
  if (o.profile.value_or("").empty() || profile.empty() || o.is_broker_by_flag) return {};
  Texts own;
  AddBrokers(context.config.profiles.find(profile)->second, own);
  if (own.empty() || FindStranger(brokers, own) == nullptr) return {};
  return Fail(
      ErrorKind::kUsage,
      fmt::format(
          "profile {} has the broker {}, but {} another: leave that out, or name one with --broker",
          base::Printable(profile), base::Printable(base::Join(own, ", ")), WhoNamesTheBroker(o)));
}

Status CheckLogin(const Context& context, std::span<const mqtt::BrokerUrl> brokers) {
  const std::vector<std::string_view>& configured = context.options.configured;
  const bool any_tls = std::any_of(brokers.begin(), brokers.end(),
                                   [](const auto& broker) { return broker.UsesTls(); });
  for (const auto& [key, way_out, is_for_tls] : kLogin) {
    if (is_for_tls && !any_tls) continue;
    if (std::find(configured.begin(), configured.end(), key) == configured.end()) continue;
    const config::ConfigValue& value = *context.config.Find(key);
    const Texts owners = ListOwners(value, context.config);
    if (owners.empty() || value.texts.front().empty() || value.texts.front() == "false") continue;
    const mqtt::BrokerUrl* const stranger = FindStranger(brokers, owners);
    if (stranger == nullptr) continue;
    return Fail(
        ErrorKind::kUsage,
        fmt::format("{} of {} is for {}, not for {}: {}", key, value.Origin(),
                    base::Printable(base::Join(owners, ", ")), stranger->ToString(), way_out));
  }
  return {};
}

}  // namespace fleetpub::cli
