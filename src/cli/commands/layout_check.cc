// `fleetpub layout check FILE…`: what is wrong or odd in layouts.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "app/check_layout.h"
#include "base/file.h"
#include "base/json.h"
#include "base/json_place.h"
#include "base/text.h"
#include "cli/layout_file.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "layout/check.h"
#include "layout/route.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using layout::LayoutFinding;
using Level = LayoutFinding::Level;

struct LayoutCheckOptions {
  std::vector<std::string> files;
  std::string version;
  std::string factsheet;
  std::string vehicle_type;
};

class Checker {
 public:
  Checker(const LayoutCheckOptions& options, Output& output) : options_(options), output_(output) {}

  Status Prepare() {
    if (!options_.version.empty()) {
      const auto version = vda5050::ParseVersion(options_.version);
      if (!version) return Fail(version.error());
      version_ = *version;
    }
    if (options_.factsheet.empty()) return {};
    const auto text = base::ReadFile(options_.factsheet);
    if (!text) return Fail(text.error());
    auto message = vda5050::ReadMessage(*text);
    if (!message) {
      return Fail(message.error().kind,
                  fmt::format("{}: {}", ShownFile(options_.factsheet), message.error().message));
    }
    factsheet_ = std::make_unique<base::JsonDocument>(std::move(*message));
    return {};
  }

  // Errors: it cannot be read.
  Status Check(const std::string& file) {
    const auto text = base::ReadFile(file);
    if (!text) return Fail(text.error());
    std::vector<LayoutFinding> findings;
    auto read = layout::ReadLayout(*text);
    if (!read) {
      findings.push_back({Level::kError, "", read.error().message});
      return Tell(file, *text, std::move(findings), !base::FindFault(*text));
    }
    findings = std::move(read->findings);
    layout::CheckElements(read->site, findings);
    layout::CheckWays(read->site, findings);
    app::CheckLayoutActions(read->site, version_, findings);
    if (auto ok = CheckBeside(read->site, findings); !ok) return ok;
    return Tell(file, *text, std::move(findings), true);
  }

  void Tell(const Error& error) {
    code_ = Worse(code_, GetExitCode(error.kind));
    output_.PrintError(error);
  }

  void ShowSummary() {
    if (output_.json()) {
      return output_.Line(
          fmt::format(R"({{"summary":{{"files":{},"errors":{},"warnings":{},"exitCode":{}}}}})",
                      options_.files.size(), errors_, warnings_, static_cast<int>(code_)));
    }
    const std::string name = options_.files.size() == 1
                                 ? ShownFile(options_.files.front())
                                 : fmt::format("{} files", options_.files.size());
    output_.PeopleLine(fmt::format("{}: {}, {}", name, base::Counted(errors_, "error"),
                                   base::Counted(warnings_, "warning")));
  }

  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  Status CheckBeside(const layout::Site& site, std::vector<LayoutFinding>& findings) {
    if (!factsheet_) return {};
    const auto sheet = vda5050::ReadFactsheet(*factsheet_);
    const auto type = layout::ChooseVehicleType(
        site, options_.vehicle_type,
        fmt::format("{}.{}", sheet.header.manufacturer, sheet.specification.series));
    if (!type) return Fail(type.error());
    app::CheckLayoutBeside(*factsheet_, site, *type, findings);
    return {};
  }

  Status Tell(const std::string& file, std::string_view text, std::vector<LayoutFinding> findings,
              bool is_json) {
    std::vector<std::string> pointers;
    pointers.reserve(findings.size());
    for (const auto& finding : findings) pointers.push_back(finding.place);
    std::vector<base::JsonPlace> places(findings.size());
    if (is_json) {
      places = base::FindPlaces(text, pointers);
    } else if (const auto fault = base::FindFault(text)) {
      places.front() = *fault;
    }
    std::vector<std::size_t> order(findings.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(places[a].line, places[a].column) <
             std::pair(places[b].line, places[b].column);
    });
    for (const std::size_t i : order) Show(file, findings[i], places[i]);
    return {};
  }

  void Show(const std::string& file, const LayoutFinding& finding, const base::JsonPlace& place) {
    const bool is_error = finding.level == Level::kError;
    ++(is_error ? errors_ : warnings_);
    if (is_error) code_ = Worse(code_, ExitCode::kInvalid);
    const std::string_view level = is_error ? "error" : "warning";
    if (output_.json()) {
      const std::string name = file == "-" ? "" : fmt::format(R"("file":{},)", JsonString(file));
      return output_.Line(fmt::format(
          R"({{{}"level":"{}","path":{},"message":{},"line":{},"column":{}}})", name, level,
          JsonString(finding.place), JsonString(finding.text), place.line, place.column));
    }
    if (!is_error && output_.quiet()) return;
    output_.Line(fmt::format("{}:{}:{}: {}: {}{}{}", ShownFile(file), place.line, place.column,
                             output_.Toned(is_error ? Tone::kBad : Tone::kWarn, level),
                             base::Printable(finding.place), finding.place.empty() ? "" : ": ",
                             finding.text));
  }

  const LayoutCheckOptions& options_;
  Output& output_;
  vda5050::Version version_ = vda5050::kVersions.back();
  std::unique_ptr<base::JsonDocument> factsheet_;
  std::size_t errors_ = 0;
  std::size_t warnings_ = 0;
  ExitCode code_ = ExitCode::kDone;
};

Result<ExitCode> RunCheck(const LayoutCheckOptions& options, const Context& context) {
  LayoutCheckOptions chosen = options;
  if (chosen.files.empty()) {
    const auto* const configured = context.config.Find("layout");
    if (configured == nullptr) return Fail(ErrorKind::kUsage, "which layout? name its FILE");
    chosen.files = configured->texts;
  }
  Checker checker(chosen, context.output);
  if (auto ready = checker.Prepare(); !ready) return Fail(std::move(ready.error()));
  for (const std::string& file : chosen.files) {
    const Status checked = checker.Check(file);
    if (!checked && chosen.files.size() == 1) return Fail(checked.error());
    if (!checked) checker.Tell(checked.error());
  }
  checker.ShowSummary();
  return checker.code();
}

}  // namespace

Run DeclareLayoutCheck(OptionSet& set) {
  const auto options = std::make_shared<LayoutCheckOptions>();
  set.AddOption("file", options->files,
                "Layouts (LIF); - is standard input [layout of the configuration]")
      .Type("FILE");
  set.AddOption("--vda", VdaVersion(options->version, Automatic::kNo),
                "Whose predefined actions are meant: {} [3.0.0]")
      .Type("V")
      .Group("Checking")
      .Variable("FLEETPUB_VDA");
  set.AddOption("--factsheet", options->factsheet, "A robot's factsheet, to be held against it")
      .Type("FILE")
      .Group("Checking");
  set.AddOption("--vehicle-type", options->vehicle_type,
                "The vehicle type of the factsheet [manufacturer.seriesName, or the only one]")
      .Type("TYPE")
      .Group("Checking");
  return [options](const Context& context) { return RunCheck(*options, context); };
}

}  // namespace fleetpub::cli
