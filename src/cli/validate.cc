// `fleetpub validate`: messages against a built-in schema or a given one, and against the rules of
// the text.
#include "dispatch/validate.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "base/file.h"
#include "base/json.h"
#include "base/text.h"
#include "cli/soar_validate.h"
#include "cli/subcommand.h"
#include "schema/schema.h"
#include "vda5050/text_rules.h"

namespace fleetpub::cli {
namespace {

using dispatch::Findings;

struct Options {
  std::string file = "-";
  std::string version;
  std::string topic;
  std::string schema_file;
  std::string protocol = "vda5050";
  std::string message_type;
  bool lines = false;
  bool strict = false;
};

// A message's topic, told from the member that only this topic has.
struct Mark {
  std::string_view member;
  std::string_view topic;
};
constexpr std::array<Mark, 3> kMarks = {{
    {"actions", "instantActions"},
    {"instantActions", "instantActions"},
    {"connectionState", "connection"},
}};

// Validates message after message; each schema is compiled once.
class Validator {
 public:
  Validator(const Options& options, const Context& context)
      : options_(options), registry_(context.options.schema_directory) {}

  // Errors: the options or the schema, not a message.
  Status Prepare() {
    if (!options_.schema_file.empty()) return LoadFile();
    if (auto soar = PrepareSoar(); !soar || soar_) return soar;
    if (!options_.version.empty()) {
      const auto version = vda5050::ParseVersion(options_.version);
      if (!version) return Fail(version.error());
      version_ = *version;
    }
    if (version_ && !options_.topic.empty()) {
      const auto schema = registry_.Find(SchemaName(*version_, options_.topic));
      if (!schema) return Fail(schema.error());
    }
    return {};
  }

  Findings Check(std::string_view text) {
    const auto message = base::ParseJson(text);
    if (!message) return OneError(message.error().message);
    if (own_schema_) return dispatch::Check(*message, *own_schema_, {});
    if (soar_) return soar_->Check(*message, registry_);
    const auto version = VersionOf(*message);
    if (!version) return OneError(version.error().message);
    const auto topic = TopicOf(*message);
    if (!topic) return OneError(topic.error().message);
    const auto schema = registry_.Find(SchemaName(*version, *topic));
    if (!schema) return OneError(schema.error().message);
    Findings findings = dispatch::Check(*message, **schema, RulesOf(*version, *topic));
    return options_.strict ? findings : Softened(std::move(findings));
  }

 private:
  Status PrepareSoar() {
    const auto is_soar = IsSoar(options_.protocol);
    if (!is_soar) return Fail(is_soar.error());
    if (!*is_soar && options_.message_type.empty()) return {};
    if (!*is_soar) return Fail(ErrorKind::kUsage, "--message-type belongs to --protocol soar");
    if (!options_.topic.empty()) {
      return Fail(ErrorKind::kUsage, "--topic belongs to VDA 5050: name a --message-type");
    }
    const auto validator =
        SoarValidator::Make(options_.message_type,
                            options_.strict ? soar::Strictness::kRefuse : soar::Strictness::kWarn);
    if (!validator) return Fail(validator.error());
    soar_ = *validator;
    return {};
  }

  Status LoadFile() {
    const auto text = base::ReadFile(options_.schema_file);
    if (!text) return Fail(text.error());
    auto schema = schema::Schema::Compile(*text, options_.schema_file);
    if (!schema) return Fail(std::move(schema.error()));
    own_schema_ = std::move(*schema);
    return {};
  }

  static Findings OneError(std::string message) { return {{{"", std::move(message)}}, {}}; }

  static std::string SchemaName(vda5050::Version version, std::string_view topic) {
    return fmt::format("vda5050/{}/{}", vda5050::FactsOf(version).name, topic);
  }

  static dispatch::TextRules RulesOf(vda5050::Version version, std::string_view topic) {
    if (topic != "instantActions") return {};
    return [version](const rapidjson::Value& message) {
      return vda5050::CheckInstantActions(message, version);
    };
  }

  // The text's rules are no schema rules: they warn here, and fail with --strict.
  static Findings Softened(Findings findings) {
    if (!findings.satisfies_schema) return findings;
    std::move(findings.warnings.begin(), findings.warnings.end(),
              std::back_inserter(findings.errors));
    return {{}, std::move(findings.errors)};
  }

  [[nodiscard]] Result<vda5050::Version> VersionOf(const rapidjson::Value& message) const {
    if (version_) return *version_;
    const std::string_view text = base::StringMember(message, "version");
    for (const vda5050::Version version : vda5050::kVersions) {
      if (vda5050::FactsOf(version).name == text) return version;
    }
    return Fail(ErrorKind::kInvalid,
                "its header does not say which VDA 5050 version it is: name it with --vda");
  }

  [[nodiscard]] Result<std::string> TopicOf(const rapidjson::Value& message) const {
    if (!options_.topic.empty()) return options_.topic;
    for (const auto& [member, topic] : kMarks) {
      if (base::FindMember(message, member) != nullptr) return std::string(topic);
    }
    return Fail(ErrorKind::kInvalid,
                "it cannot be told which topic it belongs to: name it with --topic");
  }

  const Options& options_;
  schema::Registry registry_;
  std::optional<vda5050::Version> version_;
  std::optional<schema::Schema> own_schema_;
  std::optional<SoarValidator> soar_;
};

std::string ListJson(const std::vector<schema::Violation>& violations) {
  std::string json;
  for (const auto& [path, message] : violations) {
    json += fmt::format(R"({}{{"path":{},"message":{}}})", json.empty() ? "" : ",",
                        base::JsonString(path), base::JsonString(message));
  }
  return "[" + json + "]";
}

// Prints what was found in one message; `line` is 0 when the input is one message.
void Show(const Findings& findings, const std::string& name, std::size_t line, Output& output) {
  if (output.json()) {
    const std::string number = line == 0 ? "" : fmt::format(R"("line":{},)", line);
    return output.Line(fmt::format(R"({{{}"valid":{},"errors":{},"warnings":{}}})", number,
                                   findings.errors.empty(), ListJson(findings.errors),
                                   ListJson(findings.warnings)));
  }
  const std::string place = line == 0 ? name : fmt::format("{}:{}", name, line);
  for (const auto& [path, message] : findings.errors) {
    output.Line(fmt::format("{}: {}{}{}", place, path, path.empty() ? "" : ": ", message));
  }
  for (const auto& [path, message] : findings.warnings) {
    output.Warn(fmt::format("{}: {}{}{}", place, path, path.empty() ? "" : ": ", message));
  }
  if (findings.errors.empty()) output.PeopleLine(fmt::format("{}: valid", place));
}

Result<ExitCode> RunValidate(const Options& options, const Context& context) {
  Validator validator(options, context);
  if (auto ready = validator.Prepare(); !ready) return Fail(ready.error());
  const auto content = base::ReadFile(options.file);
  if (!content) return Fail(content.error());
  const std::string name = options.file == "-" ? "standard input" : options.file;
  if (!options.lines) {
    const Findings findings = validator.Check(*content);
    Show(findings, name, 0, context.output);
    return findings.errors.empty() ? ExitCode::kDone : ExitCode::kInvalid;
  }
  ExitCode code = ExitCode::kDone;
  std::size_t number = 0;
  std::string_view rest = *content;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const Findings findings = validator.Check(line);
    Show(findings, name, number, context.output);
    if (!findings.errors.empty()) code = ExitCode::kInvalid;
  }
  return code;
}

}  // namespace

Run DeclareValidate(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    return app.add_option(names, value, help)->type_name(type)->group("Checking");
  };
  app.add_option("file", options->file, "The message; - or nothing: standard input")
      ->type_name("FILE");
  add("--vda", options->version, "V", "Version [what the header says]")->envname("FLEETPUB_VDA");
  add("--topic", options->topic, "TOPIC", "instantActions, connection [told from the message]");
  add("--protocol", options->protocol, "NAME", "vda5050 or soar [vda5050]");
  add("--message-type", options->message_type, "TYPE",
      "With --protocol soar: the payload must be of this type, and may stand alone");
  add("--schema", options->schema_file, "FILE", "A JSON Schema of your own (draft-07)");
  app.add_flag("--lines", options->lines, "One message per line (JSON Lines)")->group("Checking");
  app.add_flag("--strict", options->strict, "Rules of the specification's text are errors too")
      ->group("Checking");
  return [options](const Context& context) { return RunValidate(*options, context); };
}

}  // namespace fleetpub::cli
