#include "app/dialect_resolver.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"

namespace fleetpub::app {
namespace {

using vda5050::Dialect;

VdaOptions Completed(VdaOptions given, const auto& find) {
  const auto take = [&](std::string_view key, std::string& text) {
    if (!text.empty()) return;
    if (const config::ConfigValue* value = find(key)) text = value->texts.front();
  };
  take("vda", given.version);
  take("interface", given.interface_name);
  take("topic_template", given.topic_template);
  take("actions_key", given.actions_key);
  take("header_version", given.header_version);
  take("header_manufacturer", given.header_manufacturer);
  take("header_serial", given.header_serial);
  return given;
}

Result<std::shared_ptr<const Dialect>> Shared(const VdaOptions& options,
                                              std::optional<vda5050::Version> assumed) {
  auto dialect = ParseDialect(options);
  if (!dialect) return Fail(std::move(dialect.error()));
  if (dialect->assumed && assumed) {
    dialect->version = *assumed;
    dialect->assumed = false;
  }
  return std::make_shared<const Dialect>(*std::move(dialect));
}

}  // namespace

Result<vda5050::Dialect> ParseDialect(const VdaOptions& o) {
  vda5050::Dialect dialect;
  dialect.assumed = o.IsAutomatic();
  if (!dialect.assumed) {
    const auto version = vda5050::ParseVersion(o.version);
    if (!version) return Fail(version.error());
    dialect.version = *version;
  }
  if (!o.actions_key.empty() && o.actions_key != "actions" && o.actions_key != "instantActions") {
    return Fail(ErrorKind::kUsage, fmt::format("--actions-key is actions or instantActions, not "
                                               "'{}'",
                                               base::Printable(o.actions_key)));
  }
  for (const std::string& text : {o.header_version, o.header_manufacturer, o.header_serial}) {
    if (!base::IsUtf8(text)) {
      return Fail(ErrorKind::kUsage, "--header-...: the text is not valid UTF-8");
    }
  }
  if (!o.interface_name.empty()) {
    if (auto ok = vda5050::CheckInterface(o.interface_name); !ok) {
      return Fail(std::move(ok.error()));
    }
  }
  dialect.topics.interface_name = o.interface_name;
  if (!o.topic_template.empty()) dialect.topics.topic_template = o.topic_template;
  dialect.actions_key = o.actions_key;
  dialect.header_version = o.header_version;
  dialect.header_manufacturer = o.header_manufacturer;
  dialect.header_serial = o.header_serial;
  return dialect;
}

Status TopicOwners::Add(const vda5050::RobotAddress& robot, const vda5050::TopicScheme& scheme,
                        bool waits) {
  if (waits && !scheme.Names("{topic}")) {
    return Fail(
        ErrorKind::kUsage,
        fmt::format("topic template '{}' has no {{topic}}, so no state of {} can be "
                    "waited for: leave out --wait",
                    base::Printable(scheme.topic_template), base::Printable(robot.ToString())));
  }
  if (scheme.Names("{manufacturer}")) return {};
  const auto [other, is_new] = by_serial_.emplace(robot.serial_number, robot);
  if (is_new || other->second == robot) return {};
  return Fail(
      ErrorKind::kUsage,
      fmt::format("topic template '{}' lacks {{manufacturer}}: {} and {} would get each "
                  "other's messages",
                  base::Printable(scheme.topic_template), base::Printable(other->second.ToString()),
                  base::Printable(robot.ToString())));
}

VdaOptions WithConfig(VdaOptions given, const config::Config& config) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(key); });
}

VdaOptions WithConfig(VdaOptions given, const config::Config& config,
                      const vda5050::RobotAddress& robot) {
  return Completed(std::move(given), [&](std::string_view key) { return config.Find(robot, key); });
}

Result<DialectResolver> DialectResolver::Make(const VdaOptions& given,
                                              const config::Config& config) {
  DialectResolver resolver(given, config);
  const VdaOptions common = WithConfig(given, config);
  auto dialect = Shared(common, {});
  if (!dialect) return Fail(std::move(dialect.error()));
  resolver.common_ = *std::move(dialect);
  return resolver;
}

Result<AddressedRobot> DialectResolver::Resolve(vda5050::RobotAddress robot) const {
  auto dialect = common_;
  if (config_->robots.contains(robot)) {
    auto own = Shared(WithConfig(given_, *config_, robot), assumed_);
    if (!own) return Fail(std::move(own.error()));
    dialect = *std::move(own);
  }
  const bool is_assumed = dialect->assumed;
  return AddressedRobot{std::move(robot), std::move(dialect), is_assumed};
}

Result<std::vector<vda5050::TopicScheme>> DialectResolver::Schemes() const {
  std::vector<vda5050::TopicScheme> schemes = {common_->topics};
  for (const auto& [robot, table] : config_->robots) {
    const auto own = Resolve(robot);
    if (!own) return Fail(own.error());
    const vda5050::TopicScheme& scheme = own->dialect->topics;
    if (std::find(schemes.begin(), schemes.end(), scheme) == schemes.end()) {
      schemes.push_back(scheme);
    }
  }
  return schemes;
}

void DialectResolver::Assume(vda5050::Version version) {
  assumed_ = version;
  if (!common_->assumed) return;
  Dialect dialect = *common_;
  dialect.version = version;
  dialect.assumed = false;
  common_ = std::make_shared<const Dialect>(std::move(dialect));
}

}  // namespace fleetpub::app
