// `fleetpub soar planning-configuration DESTINATION --file FILE`: squads and zones from JSON or
// TOML.
#include <fmt/format.h>

#include <memory>

#include "base/file.h"
#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/soar_sending.h"
#include "config/toml_text.h"

namespace fleetpub::cli {
namespace {

struct SoarPlanningConfigurationOptions {
  FieldOptions fields;
  std::string file;
  SoarSendingOptions sending;
};

bool IsToml(std::string_view name, std::string_view content) {
  const std::string folded = base::ToLower(name);
  if (folded.ends_with(".toml")) return true;
  if (folded.ends_with(".json")) return false;
  const auto first = content.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first == std::string_view::npos || content[first] != '{';
}

Result<std::string> PayloadFrom(std::string_view name, std::string_view content,
                                std::string_view id) {
  if (!IsToml(name, content)) return soar::ParsePlanningConfiguration(content, id);
  const auto json = config::TomlToJson(content);
  if (!json) return Fail(json.error());
  return soar::ParsePlanningConfiguration(*json, id);
}

Result<ExitCode> RunPlanningConfiguration(const SoarPlanningConfigurationOptions& options,
                                          const Context& context) {
  if (options.file.empty()) {
    return Fail(ErrorKind::kUsage,
                "a planning configuration comes from a file: name it with --file");
  }
  const auto members = options.fields.Members();
  if (!members) return Fail(members.error());
  const auto content = base::ReadFile(options.file);
  if (!content) return Fail(content.error());
  const auto payload =
      PayloadFrom(options.file, *content, members->empty() ? "" : members->front().json);
  if (!payload) {
    const std::string name = options.file == "-" ? "standard input" : base::Printable(options.file);
    return Fail(payload.error().kind, fmt::format("{}: {}", name, payload.error().message));
  }
  return SendSoarMessage(options.sending, soar::MessageType::kPlanningConfiguration, *payload,
                         context);
}

}  // namespace

Run DeclareSoarPlanningConfiguration(OptionSet& set) {
  const auto options = std::make_shared<SoarPlanningConfigurationOptions>();
  set.AddOption("-f,--file", options->file,
                "Squads, platforms and zones: JSON or TOML; - is standard input")
      .Type("FILE")
      .Group("Payload");
  options->fields.Declare(set, soar::ListFields(soar::MessageType::kPlanningConfiguration));
  DeclareSoarSending(set, options->sending);
  return [options](const Context& context) { return RunPlanningConfiguration(*options, context); };
}

}  // namespace fleetpub::cli
