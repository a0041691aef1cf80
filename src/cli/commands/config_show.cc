// `fleetpub config show`: the settings in force, and where each comes from.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "base/width.h"
#include "cli/options/password.h"
#include "cli/options/sending_options.h"
#include "cli/options/soar_options.h"
#include "cli/options/vda_options.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config_files.h"
#include "config/config_settings.h"
#include "ledger/postgres/postgres_url.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;

constexpr std::string_view kMask = "********";

// What other commands take, so that its variables are seen here too.
struct ConfigShowOptions {
  mqtt::Qos qos = mqtt::Qos::kAtMostOnce;
  app::VdaOptions vda;
  std::string source;
  std::string prefix;
  std::string layout;
};

struct SettingRow {
  std::string key;
  std::string value;
  std::string origin;
};

std::string_view FindStandard(std::string_view key) {
  for (const config::Setting& setting : config::Settings()) {
    if (setting.key == key) return setting.standard;
  }
  return "";
}

// A URL without its login's password: http://user:********@host.
std::string Masked(const std::string& text) {
  const std::size_t at = text.rfind('@');
  const std::size_t scheme = text.find("://");
  const std::size_t start = scheme == std::string::npos ? 0 : scheme + 3;
  if (at == std::string::npos || at < start) return text;
  const std::size_t colon = text.find(':', start);
  if (colon == std::string::npos || colon > at) return text;
  return text.substr(0, colon + 1) + std::string(kMask) + text.substr(at);
}

bool MayHoldALogin(std::string_view key) { return key == "broker" || key == "proxy"; }

// A password in it is refused as soon as the ledger is opened, but this command opens none.
std::string MaskedLedger(const std::string& text) {
  const bool may_be_shown = !ledger::IsUrl(text) || ledger::CheckPostgresUrl(text);
  return may_be_shown ? text : ledger::FormatPlace(text);
}

SettingRow MakeRow(const OptionSet::Setting& setting) {
  SettingRow row{std::string(setting.key), {}, setting.origin};
  if (setting.texts.empty()) {
    row.value = FindStandard(setting.key);
    return row;
  }
  std::vector<std::string> texts = setting.texts;
  if (MayHoldALogin(setting.key)) std::transform(texts.begin(), texts.end(), texts.begin(), Masked);
  if (setting.key == "ledger") texts.front() = MaskedLedger(texts.front());
  row.value = base::Join(texts, setting.key == config::kPasswordCommand ? " " : ", ");
  return row;
}

std::optional<SettingRow> PasswordRow(const GlobalOptions& options) {
  const auto row = [](std::string origin) {
    return SettingRow{"password", std::string(kMask), std::move(origin)};
  };
  if (options.ask_password) return row("flag --ask-password");
  if (!options.password_file.empty()) return row(fmt::format("file {}", options.password_file));
  if (std::getenv("FLEETPUB_PASSWORD") != nullptr) {
    return row("environment variable FLEETPUB_PASSWORD");
  }
  if (HasPasswordInEnvironment()) return row("systemd credential fleetpub.password");
  if (!options.password_command.empty()) return row("password_command");
  return std::nullopt;
}

SettingRow ProfileRow(const OptionSet& set, const Context& context) {
  SettingRow row{"profile", context.config.profile, "default"};
  if (context.options.profile) {
    row.origin = set.Origin(set.Find("--profile"));
  } else if (context.config.default_profile) {
    row.origin = context.config.default_profile->Origin();
  }
  return row;
}

void AddRobots(const config::Config& config, std::vector<SettingRow>& rows) {
  for (const auto& [robot, table] : config.robots) {
    for (const auto& [key, value] : table.settings) {
      rows.push_back(
          {fmt::format("robot.{}.{}", robot.ToString(), key), value.texts.front(), value.Origin()});
    }
  }
  for (const auto& [name, group] : config.groups) {
    std::vector<std::string> robots;
    for (const auto& robot : config.group_robots.at(name)) robots.push_back(robot.ToString());
    rows.push_back({"group." + name, base::Join(robots, ", "), group.place.ToString()});
  }
}

void Show(const std::vector<SettingRow>& rows, Output& output) {
  std::size_t key_width = 0;
  std::size_t value_width = 0;
  for (const SettingRow& row : rows) {
    key_width = std::max(key_width, base::MeasureWidth(base::Printable(row.key)));
    value_width = std::max(
        value_width, std::min<std::size_t>(base::MeasureWidth(base::Printable(row.value)), 40));
  }
  for (const SettingRow& row : rows) {
    if (output.json()) {
      output.Line(fmt::format(R"({{"key":{},"value":{},"origin":{}}})", JsonString(row.key),
                              JsonString(row.value), JsonString(row.origin)));
    } else {
      const std::string value = row.value.empty() ? "-" : base::Printable(row.value);
      output.Line(fmt::format("{}  {}  {}", base::Padded(key_width, base::Printable(row.key)),
                              base::Padded(value_width, value), base::Printable(row.origin)));
    }
  }
}

Result<ExitCode> RunConfigShow(const OptionSet& set, const Context& context) {
  std::vector<SettingRow> rows = {ProfileRow(set, context)};
  for (const auto& setting : set.Settings(context.config)) {
    const bool is_place = setting.key == "host" || setting.key == "port";
    if (is_place && setting.texts.empty()) continue;
    rows.push_back(MakeRow(setting));
    if (setting.key != "password_file") continue;
    if (auto password = PasswordRow(context.options)) rows.push_back(*std::move(password));
  }
  if (const auto password = PasswordRow(context.options);
      password && std::none_of(rows.begin(), rows.end(),
                               [](const SettingRow& row) { return row.key == "password"; })) {
    rows.push_back(*password);  // it stands instead of the configuration's password_file
  }
  AddRobots(context.config, rows);
  if (!context.output.json()) {
    const auto& files = context.config.files;
    context.output.PeopleLine(files.empty() ? "no configuration file"
                                            : "read: " + base::Printable(base::Join(files, ", ")));
  }
  Show(rows, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareConfigShow(OptionSet& set) {
  const auto options = std::make_shared<ConfigShowOptions>();
  DeclareQos(set, options->qos);
  const auto add = [&](const char* key, const char* name, ValueKind kind, const char* help) {
    return set.AddOption(name, std::move(kind), help).Group("VDA 5050").Key(key);
  };
  add("vda", "--vda", VdaVersion(options->vda.version), "Version to speak")
      .Variable("FLEETPUB_VDA");
  add("interface", "--interface", Text(options->vda.interface_name), "First topic level")
      .Variable("FLEETPUB_INTERFACE");
  add("topic_template", "--topic-template", Text(options->vda.topic_template), "The topic");
  set.AddSetting("layout", Text(options->layout));
  DeclareSource(set, options->source);
  DeclarePrefix(set, options->prefix);
  return [options, &set](const Context& context) { return RunConfigShow(set, context); };
}

}  // namespace fleetpub::cli
