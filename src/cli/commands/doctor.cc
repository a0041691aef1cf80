// `fleetpub doctor`: configuration, ledger, credentials, brokers, rights and fleet, each with its
// remedy.
#include "app/doctor.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "base/json.h"
#include "base/text.h"
#include "base/width.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/password.h"
#include "cli/options/target_options.h"
#include "cli/output/interrupt.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "cli/parser/try_command.h"
#include "config/config_files.h"

namespace fleetpub::cli {
namespace {

using app::Diagnosis;
using app::Health;
using base::JsonString;

constexpr std::size_t kMostAlike = 5;  // lines of a check; JSON has them all

struct DoctorOptions {
  TargetOptions targets;
  app::VdaOptions vda;
  std::optional<std::chrono::milliseconds> duration;
  std::string from;
};

std::string_view GetName(Health health) {
  constexpr auto kNames = std::to_array<std::string_view>({"ok", "warning", "problem", "unknown"});
  return kNames[static_cast<std::size_t>(health)];
}

// Prints what is found, and counts.
class Findings {
 public:
  explicit Findings(Output& output) : output_(output) {}

  /// Names the broker in the commands that are suggested from now on.
  void SetSite(std::vector<std::string> words) { site_ = std::move(words); }

  void Tell(Diagnosis found) {
    ++counts_[found.health];
    if (found.health == Health::kProblem) code_ = Worse(code_, GetExitCode(found.kind));
    auto& command = found.remedy.command;
    if (!command.empty() && command.front() == "fleetpub") {
      command.insert(command.end(), site_.begin(), site_.end());
    }
    if (output_.json()) return output_.Line(ToJson(found));
    if (found.check != check_) TellLeftOut();
    check_ = found.check;
    if (++alike_[found.health] > kMostAlike) return;
    Show(found);
    Output::FlushNow();
  }

  void TellError(std::string_view check, std::string subject, const Error& error,
                 std::vector<std::string> command) {
    Tell({check,
          Health::kProblem,
          std::move(subject),
          error.message,
          {std::move(command)},
          error.kind});
  }

  void Summarise(std::size_t robots, const std::string& site) {
    const auto ok = counts_[Health::kOk];
    const auto warnings = counts_[Health::kWarning];
    const auto problems = counts_[Health::kProblem];
    const auto unknown = counts_[Health::kUnknown];
    if (output_.json()) {
      return output_.Line(fmt::format(
          R"({{"summary":{{"ok":{},"warnings":{},"problems":{},"unknown":{},"robots":{},"site":{},"exitCode":{}}}}})",
          ok, warnings, problems, unknown, robots, JsonString(site), static_cast<int>(code_)));
    }
    TellLeftOut();
    output_.PeopleLine(fmt::format("{}, {}, {} ok, {} unknown; nothing was sent to robots",
                                   base::Counted(problems, "problem"),
                                   base::Counted(warnings, "warning"), ok, unknown));
  }

  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  static std::string ToJson(const Diagnosis& found) {
    const std::string line = ShellLine(found.remedy.command);
    return fmt::format(
        R"({{"check":"{}","health":"{}","subject":{},"message":{}{}{}}})", found.check,
        GetName(found.health), JsonString(found.subject), JsonString(found.text),
        line.empty() ? "" : ",\"try\":" + JsonString(line),
        found.remedy.advice.empty() ? "" : ",\"advice\":" + JsonString(found.remedy.advice));
  }

  // What is right is for people only.
  void Print(Health health, const std::string& text, bool is_whole = false) const {
    const bool is_bad = health == Health::kProblem || health == Health::kWarning;
    if (!is_bad && output_.quiet()) return;
    const std::size_t width = TerminalWidth(STDOUT_FILENO);
    output_.Line(is_whole || width < 20 ? text : base::Wrapped(width, 9, text));
  }

  void Show(const Diagnosis& found) const {
    constexpr std::array kTones = {Tone::kGood, Tone::kWarn, Tone::kBad, Tone::kDim};
    const std::string health = fmt::format("{:<7}", GetName(found.health));
    Print(found.health,
          fmt::format("{}  {:<12}  {}: {}",
                      output_.Toned(kTones.at(static_cast<std::size_t>(found.health)), health),
                      found.check, base::Printable(found.subject), found.text));
    const auto& [command, advice] = found.remedy;
    if (!advice.empty()) Print(found.health, "         " + advice);
    const std::string line = ShellLine(command);
    if (line.empty()) return;
    // To be pasted: never broken.
    const bool is_ours = command.front() == "fleetpub";
    Print(found.health,
          "         " +
              (is_ours ? TryCommand(command.at(1), std::span(command).subspan(2)) : "run: " + line),
          true);
  }

  void TellLeftOut() {
    for (const auto& [health, count] : alike_) {
      if (count <= kMostAlike) continue;
      Print(health, fmt::format("{:<7}  {:<12}  {} more like these: -o json shows them all",
                                GetName(health), check_, count - kMostAlike));
    }
    alike_.clear();
  }

  Output& output_;
  std::vector<std::string> site_;
  std::string check_;                     // the last one
  std::map<Health, std::size_t> alike_;   // of that check
  std::map<Health, std::size_t> counts_;  // of all
  ExitCode code_ = ExitCode::kDone;
};

/// False: no command runs with it.
bool CheckSettings(const Context& context, Findings& findings) {
  config::Config config;
  const auto mistakes = CheckConfiguration(context.options, config);
  for (const Error& mistake : mistakes) {
    findings.TellError("settings", "configuration", mistake, {"fleetpub", "config", "check"});
  }
  if (!mistakes.empty()) return false;
  findings.Tell({"settings", Health::kOk, "configuration",
                 config.files.empty() ? "no configuration file"
                                      : base::Printable(base::Join(config.files, ", "))});
  return true;
}

void CheckLedger(const Context& context, Findings& findings) {
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
  const auto info = ledger ? (*ledger)->Describe() : Fail(ledger.error());
  if (!info) {
    return findings.TellError("ledger", "header ids and history", info.error(),
                              {"fleetpub", "ledger", "status"});
  }
  findings.Tell({"ledger", Health::kOk, base::Printable(info->place),
                 info->version == 0
                     ? "none yet, the first command makes it"
                     : fmt::format("{} rows, header ids of {} topics", info->rows, info->topics)});
}

bool IsHere(const mqtt::BrokerUrl& broker) {
  return broker.host == "localhost" || broker.host == "::1" || broker.host.starts_with("127.");
}

// What is careless about credentials is a finding, with its remedy.
class Unheard final : public app::Log {
 public:
  void Warn(std::string_view /*text*/) override {}
  void Info(std::string_view /*text*/) override {}
  void Debug(std::string_view /*text*/) override {}
};

/// Nothing: with them nothing can be said to a broker.
std::optional<mqtt::ConnectOptions> CheckCredentials(const Context& context, Findings& findings) {
  const GlobalOptions& o = context.options;
  Diagnosis found{.check = "credentials", .subject = FormatSite(context)};
  Unheard unheard;
  auto connect = MakeConnectOptions(context, unheard);
  if (!connect) {
    findings.TellError(found.check, found.subject, connect.error(), {"fleetpub", "config", "show"});
    return std::nullopt;
  }
  bool is_right = true;
  const auto warn = [&](std::string text, app::Remedy remedy) {
    is_right = false;
    findings.Tell(
        {found.check, Health::kWarning, found.subject, std::move(text), std::move(remedy)});
  };
  const std::string credential = FindPasswordCredential().value_or("");
  for (const std::string& file :
       {o.password_file, o.key_password_file, o.key_file, o.auth_data_file, credential}) {
    if (!CanOthersRead(file)) continue;
    warn(base::Printable(file) + " can be read by others", {.command = {"chmod", "600", file}});
  }
  if (o.insecure) warn("the broker's certificate is not verified", {.advice = "drop --insecure"});
  for (const mqtt::BrokerUrl& broker : connect->brokers) {
    if (!connect->password || broker.UsesTls() || IsHere(broker)) continue;
    warn("the password crosses the network in clear text to " + broker.ToString(),
         {.advice = "use mqtts:// (docs/site.md)"});
  }
  if (is_right) {
    found.text = connect->login.empty() ? "each broker has its own login" : connect->login;
    findings.Tell(std::move(found));
  }
  return *std::move(connect);
}

// The words that lead another command to the same broker.
std::vector<std::string> SiteWords(const GlobalOptions& o) {
  std::vector<std::string> words;
  if (o.config_file) words.insert(words.end(), {"--config", *o.config_file});
  if (o.profile) words.insert(words.end(), {"--profile", *o.profile});
  if (o.is_broker_by_flag) {
    for (const std::string& broker : o.brokers) words.insert(words.end(), {"-b", broker});
  }
  if (o.is_host_by_flag && !o.host.empty()) words.insert(words.end(), {"--host", o.host});
  if (o.is_host_by_flag && o.port) words.insert(words.end(), {"-p", std::to_string(*o.port)});
  return words;
}

// Whether somebody says which site is meant: then no other one is asked.
bool NamesSite(const GlobalOptions& o) {
  const bool is_configured =
      std::find(o.configured.begin(), o.configured.end(), "broker") != o.configured.end();
  const bool is_broker_given = !o.brokers.empty() && !is_configured;
  return o.profile || is_broker_given || !o.host.empty() || o.port;
}

// The first Ctrl-C ends the listening: the rest is judged by what was heard.
class Stop {
 public:
  void Begin() { stop_.emplace(); }

 private:
  const InterruptGuard before_;
  std::optional<StopSignal> stop_;
};

Result<std::size_t> Examine(const Context& context, app::DoctorRequest request,
                            const app::Environment& environment, Stop& stop, Findings& findings) {
  request.begin = [&stop] { stop.Begin(); };
  request.goes_on = [&context]() -> Result<bool> {
    if (auto ok = context.output.Flush(); !ok) return Fail(std::move(ok.error()));
    return !StopSignal::Received();
  };
  return app::Diagnose(
      request, environment, [&](const Diagnosis& found) { findings.Tell(found); }, context.output);
}

// As a command with --profile NAME and nothing else would reach it: no flag and no variable of this
// call leads to another broker, or a login to one that it is not for.
void ExamineProfile(const std::string& name, const Context& context, Stop& stop,
                    Findings& findings) {
  GlobalOptions options;
  OptionSet set(OptionSet::Extent::kAll, {});
  DeclareGlobalOptions(set, options);
  const auto fail = [&](const Error& error) {
    findings.TellError("settings", "profile " + name, error, {"fleetpub", "config", "show"});
  };
  const auto config = config::LoadConfig(context.options.config_file, name);
  if (!config) return fail(config.error());
  if (auto ok = ApplyConfig(*config, set, options); !ok) return fail(ok.error());
  options.config_file = context.options.config_file;
  options.profile = name;
  const Context site{options, context.output, *config};
  findings.SetSite(SiteWords(options));
  auto connect = CheckCredentials(site, findings);
  if (!connect) return;
  const auto environment = MakeEnvironment(site, *std::move(connect));
  const auto reached = Examine(site, {.listens = false}, environment, stop, findings);
  if (!reached) fail(reached.error());
}

Result<ExitCode> RunDoctor(const DoctorOptions& options, const Context& context) {
  if (options.duration && !options.from.empty()) return Fail(NoTimeFrom("--for"));
  auto targets = ParseTargetOptions(options.targets);
  if (!targets) return Fail(std::move(targets.error()));
  app::DoctorRequest request{.targets = *std::move(targets), .vda = options.vda};
  if (options.duration) request.duration = *options.duration;
  Findings findings(context.output);
  Stop stop;
  std::size_t robots = 0;
  if (CheckSettings(context, findings)) {
    CheckLedger(context, findings);
    findings.SetSite(SiteWords(context.options));
    std::optional<app::Environment> environment;
    if (!options.from.empty()) {
      environment.emplace(MakeEnvironment(context, options.from, delivery::Play::kAll));
    } else if (auto connect = CheckCredentials(context, findings)) {
      environment.emplace(MakeEnvironment(context, *std::move(connect)));
    }
    if (options.from.empty() && !NamesSite(context.options)) {
      ForgetVariable("FLEETPUB_PASSWORD");  // it is for the site in use
      for (const auto& [name, section] : context.config.profiles) {
        if (name != context.config.profile) ExamineProfile(name, context, stop, findings);
      }
    }
    findings.SetSite(SiteWords(context.options));
    if (environment) {
      const auto heard = Examine(context, std::move(request), *environment, stop, findings);
      if (!heard) return Fail(heard.error());
      TellRecording(*environment, context.output);
      robots = *heard;
    }
  }
  findings.Summarise(robots, options.from.empty() ? FormatSite(context) : options.from);
  return findings.code();
}

}  // namespace

Run DeclareDoctor(OptionSet& set) {
  const auto options = std::make_shared<DoctorOptions>();
  DeclareTargetWords(set, options->targets, " [all]");
  set.AddOption("--except", options->targets.except,
                "But not this robot, alias, @group or pattern; repeatable")
      .Type("TARGET")
      .OneValueEach()
      .Group("Targets");
  DeclareFrom(set, options->from);
  DeclareTopicOptions(set, options->vda);
  set.AddOption("--for", Duration(options->duration),
                "How long to listen to the robots; states are due every 30 s [35s]")
      .Group("Waiting");
  return [options](const Context& context) { return RunDoctor(*options, context); };
}

}  // namespace fleetpub::cli
