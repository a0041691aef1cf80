// `fleetpub validate`: messages against a built-in schema or a given one, and against the rules of
// the text.
#include "delivery/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/file.h"
#include "base/json.h"
#include "base/line_reader.h"
#include "base/text.h"
#include "cli/commands/validate_live.h"
#include "cli/options/soar_options.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "schema/schema.h"
#include "schema/schema_files.h"
#include "soar/message.h"
#include "soar/text_rules.h"
#include "vda5050/messages/user_message.h"
#include "vda5050/rules/conformance.h"

namespace fleetpub::cli {
namespace {

using delivery::Findings;

struct Options {
  std::vector<std::string> files;  ///< none: standard input; with --live robots
  std::string version;
  std::string topic;
  std::string schema_file;
  bool is_soar = false;
  std::optional<soar::MessageType> message_type;
  bool lines = false;
  bool strict = false;
  LiveOptions live;
};

// A message's topic, told from a member that only this topic has, or has first in this order: a
// position can stand in a state as well.
struct Mark {
  std::string_view member;
  std::string_view topic;
};
constexpr std::array<Mark, 19> kMarks = {{
    {"actions", "instantActions"},
    {"instantActions", "instantActions"},
    {"connectionState", "connection"},
    {"nodes", "order"},
    {"edges", "order"},
    {"nodeStates", "state"},
    {"edgeStates", "state"},
    {"actionStates", "state"},
    {"operatingMode", "state"},
    {"typeSpecification", "factsheet"},
    {"physicalParameters", "factsheet"},
    {"protocolLimits", "factsheet"},
    {"protocolFeatures", "factsheet"},
    {"responses", "responses"},
    {"zoneSet", "zoneSet"},
    {"referenceStateHeaderId", "visualization"},
    {"agvPosition", "visualization"},
    {"mobileRobotPosition", "visualization"},
    {"velocity", "visualization"},
}};

// Validates message after message; each schema is compiled once.
class Validator {
 public:
  Validator(const Options& options, const Context& context)
      : options_(options), registry_(context.options.schema_directory) {}

  // Errors: the options or the schema, not a message.
  Status Prepare() {
    if (!options_.schema_file.empty()) return LoadFile();
    if (auto soar = CheckSoarOptions(); !soar || options_.is_soar) return soar;
    if (!options_.version.empty()) {
      const auto version = vda5050::ParseVersion(options_.version);
      if (!version) return Fail(version.error());
      version_ = *version;
    }
    if (version_ && !options_.topic.empty()) {
      const auto schema = registry_.Find(
          fmt::format("vda5050/{}/{}", vda5050::GetFacts(*version_).name, options_.topic));
      if (!schema) return Fail(schema.error());
    }
    return {};
  }

  Findings Check(std::string_view text) {
    const auto message = base::ParseJson(text);
    if (!message) return OneError(message.error().message);
    if (own_schema_) return delivery::Check(*message, *own_schema_, {});
    if (options_.is_soar) {
      Findings findings = CheckSoar(*message);
      if (options_.strict) delivery::Harden(findings);
      return findings;
    }
    std::string chosen;
    const auto version = FindVersion(*message, chosen);
    if (!version) return OneError(version.error().message);
    const auto topic = FindTopic(*message);
    if (!topic) return OneError(topic.error().message);
    std::vector<schema::Violation> header;
    if (!chosen.empty()) header.push_back({"/version", std::move(chosen)});
    return vda5050::CheckMessage(*message, *version, *topic, options_.strict, registry_,
                                 std::move(header));
  }

 private:
  [[nodiscard]] Status CheckSoarOptions() const {
    if (!options_.is_soar && options_.message_type) {
      return Fail(ErrorKind::kUsage, "--message-type belongs to --protocol soar");
    }
    if (options_.is_soar && !options_.topic.empty()) {
      return Fail(ErrorKind::kUsage, "--topic belongs to VDA 5050: name a --message-type");
    }
    return {};
  }

  // A whole message; when a type was named, of that type, or a payload of it alone.
  Findings CheckSoar(const base::JsonValue& message) {
    const auto& type = options_.message_type;
    const bool whole = !type || base::FindMember(message, "payload") != nullptr;
    const auto schema =
        registry_.Find(whole ? std::string(soar::kMessageSchema) : soar::PayloadSchema(*type));
    if (!schema) return OneError(schema.error().message);
    const auto strictness = options_.strict ? soar::Strictness::kRefuse : soar::Strictness::kWarn;
    Findings findings = delivery::Check(message, **schema, [strictness](const auto& checked) {
      return soar::CheckMessage(checked, strictness);
    });
    if (!findings.satisfies_schema || !type) return findings;
    const auto& payload = whole ? *base::FindMember(message, "payload") : message;
    const std::string_view found = base::StringMember(payload, "message_type");
    if (found != GetName(*type)) {
      findings.errors.push_back(
          {whole ? "/payload/message_type" : "/message_type",
           fmt::format("is {}, not {}", base::Printable(found), GetName(*type))});
    }
    return findings;
  }

  Status LoadFile() {
    const auto text =
        schema::ReadSchemaFile(options_.schema_file, schema::FilesBeside(options_.schema_file));
    if (!text) return Fail(text.error());
    auto schema = schema::Schema::Compile(*text, options_.schema_file);
    if (!schema) return Fail(std::move(schema.error()));
    own_schema_ = std::move(*schema);
    return {};
  }

  static Findings OneError(std::string message) { return {{{"", std::move(message)}}, {}}; }

  // `chosen` tells of a header that names no release.
  [[nodiscard]] Result<vda5050::Version> FindVersion(const base::JsonValue& message,
                                                     std::string& chosen) const {
    if (version_) return *version_;
    if (const auto said = vda5050::VersionSaidBy(message)) {
      if (!said->is_release) {
        chosen = vda5050::NoReleaseText(base::StringMember(message, "version"), said->version);
      }
      return said->version;
    }
    return Fail(ErrorKind::kInvalid,
                "its header does not say which VDA 5050 version it is: name it with --vda");
  }

  [[nodiscard]] Result<std::string> FindTopic(const base::JsonValue& message) const {
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

// Line by line, as they arrive and however many they are.
Result<ExitCode> CheckLines(Validator& validator, const std::string& file, const std::string& name,
                            Output& output) {
  auto reader = base::LineReader::Open(file);
  if (!reader) return Fail(std::move(reader.error()));
  ExitCode code = ExitCode::kDone;
  for (std::size_t number = 1;; ++number) {
    const auto line = reader->Next();
    if (!line) return Fail(line.error());
    if (!*line) return code;
    if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const Findings findings = validator.Check(**line);
    Show(findings, name, number, output);
    if (!findings.errors.empty()) code = ExitCode::kInvalid;
  }
}

Result<ExitCode> RunLive(const Options& options, const Context& context) {
  if (options.lines || !options.schema_file.empty() || options.is_soar || options.message_type) {
    return Fail(ErrorKind::kUsage,
                "--live goes with none of --lines, --schema, --protocol and --message-type");
  }
  LiveOptions live = options.live;
  live.targets.words = options.files;
  live.version = options.version;
  live.topic = options.topic;
  live.strict = options.strict;
  return ValidateLive(live, context);
}

Result<ExitCode> RunValidate(const Options& options, const Context& context) {
  if (options.live.live) return RunLive(options, context);
  if (options.live.AreGiven()) {
    return Fail(ErrorKind::kUsage,
                "--for, --count and the options that choose robots belong to --live");
  }
  if (options.files.size() > 1) return Fail(ErrorKind::kUsage, "name one file at a time");
  const std::string file = options.files.empty() ? "-" : options.files.front();
  Validator validator(options, context);
  if (auto ready = validator.Prepare(); !ready) return Fail(ready.error());
  const std::string name = file == "-" ? "standard input" : file;
  if (options.lines) return CheckLines(validator, file, name, context.output);
  const auto content = base::ReadFile(file);
  if (!content) return Fail(content.error());
  const Findings findings = validator.Check(*content);
  Show(findings, name, 0, context.output);
  return findings.errors.empty() ? ExitCode::kDone : ExitCode::kInvalid;
}

}  // namespace

Run DeclareValidate(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group("Checking");
  };
  set.AddOption("files", options->files, "The message; - or nothing: standard input").Type("FILE");
  add("--vda", VdaVersion(options->version, Automatic::kNo), "V", "Version [what the header says]")
      .Variable("FLEETPUB_VDA");
  add("--topic", Text(options->topic), "TOPIC",
      "order, state, instantActions … [told from the message]");
  add("--protocol", OneOf(options->is_soar, kProtocols), "NAME", "{} [vda5050]");
  add("--message-type", OneOf(options->message_type, soar::kMessageTypes), "TYPE",
      "With --protocol soar: the payload must be of this type, and may stand alone");
  add("--schema", Text(options->schema_file), "FILE", "A JSON Schema of your own (draft-07)");
  set.AddFlag("--lines", options->lines, "One message per line (JSON Lines)").Group("Checking");
  set.AddFlag("--strict", options->strict, "Rules of the specification's text are errors too")
      .Group("Checking");
  DeclareLive(set, options->live);
  return [options](const Context& context) { return RunValidate(*options, context); };
}

}  // namespace fleetpub::cli
