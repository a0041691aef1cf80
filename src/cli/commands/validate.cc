// `fleetpub validate`: messages of files, of folders and of standard input.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "base/file.h"
#include "base/json.h"
#include "base/json_place.h"
#include "base/line_reader.h"
#include "base/text.h"
#include "cli/commands/validate_live.h"
#include "cli/message_validator.h"
#include "cli/options/report_options.h"
#include "cli/options/soar_options.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

namespace fs = std::filesystem;
using delivery::Findings;

struct ValidateOptions {
  std::vector<std::string> files;  ///< none: standard input; with --live robots
  ValidatorOptions validator;
  bool lines = false;
  LiveOptions live;
  std::vector<std::string> reports;
};

// What is read: a file, or standard input (`-`).
struct Input {
  std::string file;
  bool has_lines = false;  // a message per line

  [[nodiscard]] bool IsStandard() const { return file == "-"; }
  [[nodiscard]] std::string Name() const {
    return IsStandard() ? "standard input" : base::Printable(file);
  }
};

// One message of it.
struct Checked {
  const Input& input;
  std::string_view text;
  std::size_t line = 0;  // 0: all of the input
  Findings findings;

  // Of a violation, or of what is no JSON.
  [[nodiscard]] base::JsonPlace Find(const std::string& path) const {
    const auto fault = path.empty() ? base::FindFault(text) : std::nullopt;
    base::JsonPlace place = fault ? *fault : base::FindPlace(text, path);
    if (line > 0) place.line = line;
    return place;
  }

  // `12:7: /nodes: must be …`, with its file before it where one is named.
  [[nodiscard]] std::string Describe(const schema::Violation& violation,
                                     std::string_view file = {}) const {
    const auto& [path, message] = violation;
    const base::JsonPlace place = Find(path);
    return fmt::format("{}{}{}:{}: {}{}{}", file, file.empty() ? "" : ":", place.line, place.column,
                       path, path.empty() ? "" : ": ", message);
  }
};

std::string ListJson(const Checked& checked, const std::vector<schema::Violation>& violations) {
  std::string json;
  for (const auto& [path, message] : violations) {
    const base::JsonPlace place = checked.Find(path);
    json += fmt::format(R"({}{{"path":{},"message":{},"line":{},"column":{}}})",
                        json.empty() ? "" : ",", base::JsonString(path), base::JsonString(message),
                        place.line, place.column);
  }
  return "[" + json + "]";
}

void ShowJson(const Checked& checked, Output& output) {
  std::string json;
  if (!checked.input.IsStandard()) {
    json += fmt::format(R"("file":{},)", base::JsonString(checked.input.file));
  }
  if (checked.line > 0) json += fmt::format(R"("line":{},)", checked.line);
  const Findings& findings = checked.findings;
  output.Line(fmt::format(R"({{{}"valid":{},"errors":{},"warnings":{}}})", json,
                          findings.errors.empty(), ListJson(checked, findings.errors),
                          ListJson(checked, findings.warnings)));
}

void ShowText(const Checked& checked, Output& output) {
  const auto text = [&](const schema::Violation& violation) {
    return checked.Describe(violation, checked.input.Name());
  };
  for (const auto& violation : checked.findings.errors) output.Line(text(violation));
  for (const auto& violation : checked.findings.warnings) output.Warn(text(violation));
  if (!checked.findings.errors.empty()) return;
  const std::string line = checked.line > 0 ? fmt::format(":{}", checked.line) : "";
  output.PeopleLine(fmt::format("{}{}: valid", checked.input.Name(), line));
}

TestResult MakeCase(const Checked& checked) {
  const auto& [errors, warnings, satisfies_schema] = checked.findings;
  TestResult result{.group = checked.input.file,
                    .id = checked.input.file,
                    .says = "is valid",
                    .verdict = errors.empty() ? app::Verdict::kPass : app::Verdict::kFail,
                    .why = errors.empty() ? "valid" : checked.Describe(errors.front()),
                    .details = {}};
  if (checked.line > 0) result.id += fmt::format(":{}", checked.line);
  for (const auto& violation : errors) result.details.push_back(checked.Describe(violation));
  for (const auto& violation : warnings) {
    result.details.push_back("warning: " + checked.Describe(violation));
  }
  return result;
}

// Checks inputs one after the other, and counts.
class Checker {
 public:
  /// With `keeps` it remembers a case of each message, and Ctrl-C ends the reading.
  Checker(MessageValidator& validator, Output& output, bool keeps)
      : validator_(validator), output_(output) {
    if (keeps) stop_.emplace();
  }

  // Errors: it cannot be read, or holds no message.
  Status Check(const Input& input) {
    const std::size_t before = valid_ + invalid_;
    Status read = input.has_lines ? CheckLines(input) : CheckWhole(input);
    if (read && valid_ + invalid_ == before && !IsStopped()) {
      read = Fail(ErrorKind::kInvalid, input.Name() + ": there is no message in it");
    }
    if (!read && stop_) {
      cases_.push_back(
          {input.file, input.file, "is valid", app::Verdict::kFail, read.error().message, {}});
    }
    return read;
  }

  void Tell(const Error& error) {
    code_ = Worse(code_, GetExitCode(error.kind));
    output_.PrintError(error);
  }

  void ShowSummary(std::size_t inputs) const {
    if (output_.json()) {
      return output_.Line(
          fmt::format(R"({{"summary":{{"files":{},"valid":{},"invalid":{},"exitCode":{}}}}})",
                      inputs, valid_, invalid_, static_cast<int>(code_)));
    }
    output_.PeopleLine(fmt::format("{} files: {} valid, {} invalid", inputs, valid_, invalid_));
  }

  [[nodiscard]] ExitCode code() const {
    return IsStopped() ? Worse(code_, *StopSignal::Received()) : code_;
  }
  [[nodiscard]] bool IsStopped() const { return stop_ && StopSignal::Received().has_value(); }
  [[nodiscard]] std::vector<TestResult> TakeCases() { return std::move(cases_); }

 private:
  void Take(const Checked& checked) {
    output_.json() ? ShowJson(checked, output_) : ShowText(checked, output_);
    const bool is_valid = checked.findings.errors.empty();
    ++(is_valid ? valid_ : invalid_);
    if (stop_) cases_.push_back(MakeCase(checked));
    if (!is_valid) code_ = Worse(code_, ExitCode::kInvalid);
  }

  Status CheckWhole(const Input& input) {
    const auto content = ReadWhole(input);
    if (!content) return Fail(content.error());
    if (content->find_first_not_of(" \t\r\n") == std::string::npos) return {};
    Take({input, *content, 0, validator_.Check(*content)});
    return {};
  }

  // As they arrive and however many they are.
  Status CheckLines(const Input& input) {
    auto reader = base::LineReader::Open(input.file);
    if (!reader) return Fail(std::move(reader.error()));
    for (std::size_t number = 1;; ++number) {
      const auto line = NextLine(*reader);
      if (!line) return Fail(line.error());
      if (!*line) return {};
      if ((*line)->find_first_not_of(" \t\r") == std::string_view::npos) continue;
      Take({input, **line, number, validator_.Check(**line)});
    }
  }

  // Empty once it is stopped.
  [[nodiscard]] Result<std::string> ReadWhole(const Input& input) const {
    if (!stop_ || !input.IsStandard()) return base::ReadFile(input.file);
    auto reader = base::LineReader::Open(input.file);
    if (!reader) return Fail(std::move(reader.error()));
    std::string content;
    for (;;) {
      const auto line = NextLine(*reader);
      if (!line) return Fail(line.error());
      if (!*line) return IsStopped() ? "" : content;
      content.append(**line) += '\n';
    }
  }

  // Nothing after the last one, and once it is stopped.
  [[nodiscard]] Result<std::optional<std::string_view>> NextLine(base::LineReader& reader) const {
    while (stop_ && !reader.Ready()) {
      if (IsStopped()) return std::nullopt;
      Output::FlushNow();
      std::array<pollfd, 2> arrived = {
          {{reader.descriptor(), POLLIN, 0}, {stop_->descriptor(), POLLIN, 0}}};
      poll(arrived.data(), arrived.size(), -1);
    }
    if (IsStopped()) return std::nullopt;
    return reader.Next();
  }

  MessageValidator& validator_;
  Output& output_;
  std::optional<StopSignal> stop_;
  std::vector<TestResult> cases_;
  std::size_t valid_ = 0;
  std::size_t invalid_ = 0;
  ExitCode code_ = ExitCode::kDone;
};

bool HasLines(const fs::path& file) {
  return file.extension() == ".jsonl" || file.extension() == ".ndjson";
}

// The messages below a folder in their order; what is hidden (`.git`) is passed over.
Status AddFolder(const fs::path& folder, bool lines, std::vector<Input>& inputs) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const fs::path& path = entry->path();
    if (path.filename().string().starts_with('.')) {
      entry.disable_recursion_pending();
    } else if ((path.extension() == ".json" || HasLines(path)) && entry->is_regular_file(error)) {
      files.push_back(path);
    }
  }
  if (error) {
    return Fail(ErrorKind::kLedger, fmt::format("cannot read the folder {}: {}",
                                                base::Printable(folder.string()), error.message()));
  }
  if (files.empty()) {
    return Fail(ErrorKind::kInvalid, fmt::format("{} holds no *.json, *.jsonl or *.ndjson",
                                                 base::Printable(folder.string())));
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) inputs.push_back({file.string(), lines || HasLines(file)});
  return {};
}

Result<std::vector<Input>> ListInputs(const ValidateOptions& options) {
  std::vector<Input> inputs;
  for (const std::string& file : options.files) {
    std::error_code unknown;
    if (file == "-" || !fs::is_directory(file, unknown)) {
      inputs.push_back({file, options.lines || HasLines(file)});
    } else if (auto added = AddFolder(file, options.lines, inputs); !added) {
      return Fail(std::move(added.error()));
    }
  }
  if (options.files.empty()) inputs.push_back({"-", options.lines});
  return inputs;
}

Result<ExitCode> RunLive(const ValidateOptions& options, const Context& context) {
  const ValidatorOptions& validator = options.validator;
  if (options.lines || !validator.schema_file.empty() || validator.is_soar ||
      validator.message_type || validator.body) {
    return Fail(
        ErrorKind::kUsage,
        "--live cannot be combined with --lines, --schema, --protocol, --message-type or --body");
  }
  LiveOptions live = options.live;
  live.targets.words = options.files;
  live.version = validator.version;
  live.topic = validator.topic;
  live.strict = validator.strict;
  live.reports = options.reports;
  return ValidateLive(live, context);
}

Result<ExitCode> RunValidate(const ValidateOptions& options, const Context& context) {
  if (options.live.live || !options.live.from.empty()) return RunLive(options, context);
  if (options.live.AreGiven()) {
    return Fail(ErrorKind::kUsage, "--for, --count and the options that choose robots need --live");
  }
  MessageValidator validator(options.validator, context.options.schema_directory);
  if (auto ready = validator.Prepare(); !ready) return Fail(ready.error());
  const auto inputs = ListInputs(options);
  if (!inputs) return Fail(inputs.error());
  const auto reports = ParseReportFiles(options.reports);
  if (!reports) return Fail(reports.error());
  TestReport report{.name = "fleetpub validate",
                    .properties = {},
                    .started = base::WallTime::clock::now(),
                    .results = {}};
  Checker checker(validator, context.output, !reports->empty());
  Status alone;
  for (const Input& input : *inputs) {
    if (checker.IsStopped()) break;
    const Status checked = checker.Check(input);
    if (!checked && inputs->size() == 1) alone = checked;
    if (!checked && alone) checker.Tell(checked.error());
  }
  if (inputs->size() > 1) checker.ShowSummary(inputs->size());
  if (checker.IsStopped()) report.properties.emplace_back("ended early", "interrupted");
  report.results = checker.TakeCases();
  if (auto written = WriteReports(*reports, std::move(report)); !written) {
    return Fail(std::move(written.error()));
  }
  if (!alone) return Fail(std::move(alone.error()));
  return checker.code();
}

}  // namespace

Run DeclareValidate(OptionSet& set) {
  const auto options = std::make_shared<ValidateOptions>();
  ValidatorOptions& o = options->validator;
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group("Checking");
  };
  set.AddOption("file", options->files,
                "Messages; of a folder its *.json, *.jsonl, *.ndjson; - or nothing: standard input")
      .Type("FILE");
  add("--vda", VdaVersion(o.version, Automatic::kNo), "V", "Version [what the header says]")
      .Variable("FLEETPUB_VDA");
  add("--topic", Text(o.topic), "TOPIC", "order, state, instantActions … [told from the message]");
  add("--protocol", OneOf(o.is_soar, kProtocols), "NAME", "{} [vda5050]");
  add("--message-type", OneOf(o.message_type, soar::kMessageTypes), "TYPE",
      "With --protocol soar: the payload must be of this type, and may stand alone");
  add("--schema", Text(o.schema_file), "FILE", "A JSON Schema of your own (draft-07)");
  set.AddFlag("--lines", options->lines, "One message per line, as in *.jsonl and *.ndjson")
      .Group("Checking");
  set.AddFlag("--body", o.body, "Messages whose header, or some of it, is still to come")
      .Group("Checking");
  set.AddFlag("--strict", o.strict, "Rules of the specification's text are errors too")
      .Group("Checking");
  DeclareLive(set, options->live);
  DeclareReport(set, options->reports);
  return [options](const Context& context) { return RunValidate(*options, context); };
}

}  // namespace fleetpub::cli
