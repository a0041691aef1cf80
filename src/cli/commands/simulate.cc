// `fleetpub simulate TARGET…`: virtual robots that answer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <memory>

#include "app/targets.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/commands/soar_simulate.h"
#include "cli/commands/soar_validate.h"
#include "cli/options/soar_options.h"
#include "cli/options/vda_options.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "simulator/runner.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::cli {
namespace {

using vda5050::RobotAddress;
using vda5050::Version;

constexpr std::size_t kMostRobots = 100'000;

struct Options {
  std::vector<std::string> targets;
  std::string version;
  std::string interface_name;
  std::string topic_template;
  std::string actions_key;
  std::string count = "1";
  std::string duration;
  std::string state_interval = "30s";
  std::string mode;
  bool with_order = false;
  std::string order_time;
  std::string list_limit = "0";
  std::string delay = "0";
  std::vector<std::string> fail;
  std::vector<std::string> reject;
  std::string reject_style;
  std::vector<std::string> retriable;
  bool silent = false;
  std::string drop = "0";
  std::string seed = "1";
  bool force = false;

  std::string protocol = "vda5050";
  std::string prefix = "soar";
  std::string stop_at;
};

// A number from 0 to `most`.
Result<std::uint32_t> NumberOf(const std::string& text, std::string_view option,
                               std::uint32_t most) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && number <= most) return number;
  return Fail(ErrorKind::kUsage, fmt::format("{} takes a whole number up to {}, not '{}'", option,
                                             most, base::Printable(text)));
}

struct Mode {
  std::string_view name;
  Version first;
  Version last;
};

constexpr std::array kModes = {
    Mode{"STARTUP", Version::k300, Version::k300},
    Mode{"AUTOMATIC", Version::k110, Version::k300},
    Mode{"SEMIAUTOMATIC", Version::k110, Version::k300},
    Mode{"INTERVENED", Version::k300, Version::k300},
    Mode{"MANUAL", Version::k110, Version::k300},
    Mode{"SERVICE", Version::k110, Version::k300},
    Mode{"TEACHIN", Version::k110, Version::k210},
    Mode{"TEACH_IN", Version::k300, Version::k300},
};

Result<std::string> ModeOf(const std::string& text, Version version) {
  if (text.empty()) return std::string("AUTOMATIC");
  std::vector<std::string> names;
  for (const Mode& mode : kModes) {
    if (version < mode.first || version > mode.last) continue;
    if (base::EqualsIgnoringCase(mode.name, text)) return std::string(mode.name);
    names.emplace_back(mode.name);
  }
  return Fail(ErrorKind::kUsage, fmt::format("--mode takes one of {}, not '{}'",
                                             base::Join(names, ", "), base::Printable(text)));
}

Result<simulator::RejectStyle> StyleOf(const std::string& text) {
  using simulator::RejectStyle;
  if (text.empty()) return RejectStyle::kAsTheVersionSays;
  if (text == "state") return RejectStyle::kState;
  if (text == "error") return RejectStyle::kError;
  return Fail(ErrorKind::kUsage,
              fmt::format("--reject-style is state or error, not '{}'", base::Printable(text)));
}

// `pause` → `startPause`; a manufacturer's own type stays as it is.
void AddTypes(const std::vector<std::string>& words, Version version,
              std::set<std::string, std::less<>>& types) {
  for (const std::string& word : words) {
    const auto predefined = vda5050::ActionCalled(word);
    types.emplace(predefined ? vda5050::NameIn(version, *predefined) : std::string_view(word));
  }
}

Status SetTime(const std::string& text, std::chrono::milliseconds& time) {
  if (text.empty()) return {};
  const auto parsed = base::ParseDuration(text);
  if (!parsed) return Fail(parsed.error());
  time = *parsed;
  return {};
}

Status SetTimes(const Options& o, simulator::Settings& settings) {
  if (auto ok = SetTime(o.delay, settings.delay); !ok) return ok;
  if (auto ok = SetTime(o.order_time, settings.order_time); !ok) return ok;
  if (auto ok = SetTime(o.state_interval, settings.state_interval); !ok) return ok;
  if (settings.state_interval.count() == 0) {
    return Fail(ErrorKind::kUsage, "--state-interval must be above zero");
  }
  return {};
}

Status SetDrop(const Options& o, simulator::Settings& settings) {
  const std::string text = o.drop.ends_with('%') ? o.drop.substr(0, o.drop.size() - 1) : o.drop;
  const auto percent = NumberOf(text, "--drop", 100);
  if (!percent) return Fail(percent.error());
  settings.drop = *percent / 100.0;
  const auto seed = NumberOf(o.seed, "--seed", std::numeric_limits<std::uint32_t>::max());
  if (!seed) return Fail(seed.error());
  settings.drop_seed = *seed;
  return {};
}

// As this robot, or each of them, is configured; never `auto`, which is for robots that are there.
app::VdaOptions SpokenBy(const std::vector<RobotAddress>& robots, const Options& o,
                         const config::Config& config) {
  const app::VdaOptions given{.version = o.version,
                              .interface_name = o.interface_name,
                              .topic_template = o.topic_template,
                              .actions_key = o.actions_key};
  app::VdaOptions vda = robots.size() == 1 ? app::Configured(given, config, robots.front())
                                           : app::Configured(given, config);
  if (vda.IsAutomatic()) vda.version.clear();
  return vda;
}

Result<simulator::Settings> MakeSettings(const Options& o, const app::VdaOptions& vda) {
  if (o.version == "auto") {
    return Fail(ErrorKind::kUsage, "--vda auto is for robots that are there: name a version");
  }
  const auto dialect = app::ParseDialect(vda);
  if (!dialect) return Fail(dialect.error());
  simulator::Settings settings;
  settings.version = dialect->version;
  settings.topics = dialect->topics;
  settings.actions_key = dialect->actions_key;
  const auto mode = ModeOf(o.mode, settings.version);
  if (!mode) return Fail(mode.error());
  settings.operating_mode = *mode;
  const auto style = StyleOf(o.reject_style);
  if (!style) return Fail(style.error());
  settings.reject_style = *style;
  settings.with_order = o.with_order;
  settings.silent = o.silent;
  if (auto ok = SetTimes(o, settings); !ok) return Fail(ok.error());
  if (auto ok = SetDrop(o, settings); !ok) return Fail(ok.error());
  AddTypes(o.fail, settings.version, settings.fail);
  AddTypes(o.reject, settings.version, settings.reject);
  AddTypes(o.retriable, settings.version, settings.retriable);
  if (!settings.retriable.empty() && settings.version < Version::k300) {
    return Fail(ErrorKind::kUsage, "--retriable: RETRIABLE exists from version 3.0.0 on");
  }
  const auto limit = NumberOf(o.list_limit, "--list-limit", 10'000);
  if (!limit) return Fail(limit.error());
  settings.list_limit = *limit;
  if (*limit > 0 && settings.version < Version::k300) {
    return Fail(ErrorKind::kUsage,
                "--list-limit: ended actions stay until they are cleared from version 3.0.0 on");
  }
  return settings;
}

Result<std::vector<RobotAddress>> Robots(const Options& o, const Context& context) {
  const auto count = NumberOf(o.count, "--count", kMostRobots);
  if (!count) return Fail(count.error());
  if (*count == 0) return Fail(ErrorKind::kUsage, "--count must be above zero");
  const auto targets = app::ResolveRobots(o.targets, context.config, context.output);
  if (!targets) return Fail(targets.error());
  std::vector<RobotAddress> robots;
  for (const RobotAddress& target : *targets) {
    auto some = simulator::CountUp(target, *count);
    if (!some) return Fail(std::move(some.error()));
    robots.insert(robots.end(), some->begin(), some->end());
  }
  return robots;
}

volatile std::sig_atomic_t g_stopped = 0;

// From now on Ctrl-C and `kill` are the orderly end; a second one ends at once.
void StopOnSignals() {
  struct sigaction action {};
  action.sa_handler = [](int) { g_stopped = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void Show(std::string_view robot, const simulator::Event& event, Output& output) {
  const std::string line = base::Printable(fmt::format("{}: {}", robot, event.text));
  if (event.kind == simulator::Event::Kind::kFault) {
    output.Warn(line);
  } else {
    output.Debug(line);
  }
}

// What only robots have, and was asked of platforms.
Status RefuseRobotOptions(const Options& o) {
  const Options none;
  const bool any = o.interface_name != none.interface_name ||
                   o.topic_template != none.topic_template || o.actions_key != none.actions_key ||
                   o.count != none.count || o.mode != none.mode || o.with_order ||
                   o.order_time != none.order_time || o.list_limit != none.list_limit ||
                   !o.fail.empty() || !o.reject.empty() || !o.reject_style.empty() || o.force ||
                   !o.retriable.empty() || o.drop != none.drop;
  if (!any) return {};
  return Fail(ErrorKind::kUsage,
              "with --protocol soar there are --prefix, --delay, --stop-at, --silent, "
              "--state-interval and --for; the other options are for VDA 5050");
}

Result<ExitCode> RunPlatforms(const Options& o, const Context& context) {
  if (auto ok = RefuseRobotOptions(o); !ok) return Fail(ok.error());
  return RunSoarSimulation({.destinations = o.targets,
                            .prefix = o.prefix,
                            .stop_at = o.stop_at,
                            .delay = o.delay,
                            .status_interval = o.state_interval,
                            .duration = o.duration,
                            .silent = o.silent,
                            .stopped = [] { return g_stopped != 0; },
                            .on_ready = StopOnSignals},
                           context);
}

// A fault of an action that nobody will send shows nothing.
void WarnOfMisspelt(const Options& o, Output& output) {
  for (const auto* words : {&o.fail, &o.reject, &o.retriable}) {
    for (const std::string& word : *words) {
      const auto nearest = vda5050::ActionCalled(word) ? std::nullopt : vda5050::ActionMeant(word);
      if (!nearest) continue;
      output.Warn(fmt::format("no predefined action is called '{}': did you mean {}?",
                              base::Printable(word), *nearest));
    }
  }
}

// Where robots of these names would be ONLINE.
Result<std::vector<std::string>> ConnectionFilters(const vda5050::TopicScheme& topics,
                                                   const std::vector<RobotAddress>& robots) {
  constexpr std::array<std::string_view, 1> kConnection = {"connection"};
  constexpr std::size_t kMost = 100;  // a wildcard of each would keep the broker busy for long
  std::vector<std::string> filters;
  for (const RobotAddress& robot : robots) {
    const auto own = filters.size() < kMost ? vda5050::TopicsAnywhere(topics, robot, kConnection)
                                            : vda5050::SpecifiedTopics(topics, robot, kConnection);
    if (!own) return Fail(own.error());
    filters.insert(filters.end(), own->begin(), own->end());
  }
  return filters;
}

Result<ExitCode> RunSimulate(const Options& o, const Context& context) {
  const auto is_soar = IsSoar(o.protocol);
  if (!is_soar) return Fail(is_soar.error());
  if (*is_soar) return RunPlatforms(o, context);
  if (!o.stop_at.empty()) return Fail(ErrorKind::kUsage, "--stop-at belongs to --protocol soar");
  Output& output = context.output;
  const auto robots = Robots(o, context);
  if (!robots) return Fail(robots.error());
  auto settings = MakeSettings(o, SpokenBy(*robots, o, context.config));
  if (!settings) return Fail(std::move(settings.error()));
  const vda5050::TopicScheme topics = settings->topics;
  const std::string_view version = vda5050::GetFacts(settings->version).name;
  schema::Registry registry(context.options.schema_directory);
  WarnOfMisspelt(o, output);
  const auto fleet = simulator::Fleet::Make(
      *std::move(settings), *robots, registry,
      [&](std::string_view robot, const simulator::Event& event) { Show(robot, event, output); });
  if (!fleet) return Fail(fleet.error());
  auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(std::move(connect.error()));

  simulator::RunOptions run{.connect = *std::move(connect)};
  run.connect.properties = {};  // they are a command's; what a robot is does not expire
  if (!o.duration.empty()) {
    auto duration = base::ParseDuration(o.duration);
    if (!duration) return Fail(std::move(duration.error()));
    run.duration = *duration;
  }
  if (robots->size() > simulator::kMostWills) {
    output.Debug(fmt::format("more than {} robots: they have no last will", simulator::kMostWills));
  }
  if (!o.force) {
    auto places = ConnectionFilters(topics, *robots);
    if (!places) return Fail(std::move(places.error()));
    run.places = *std::move(places);
  }
  run.stopped = [] { return g_stopped != 0; };
  run.on_lost = [&](const Error& error) { output.Lost(error); };
  run.on_unheard = [&](std::string_view topic) {
    output.Warn(
        fmt::format("what was published on {} does not come back: the broker may have "
                    "dropped it, or this login may not read it. try: -V 5, over which a "
                    "broker can say no",
                    base::Printable(topic)));
  };
  run.on_ready = [&] {
    StopOnSignals();
    Print(stderr, fmt::format("fleetpub: {} robot{} online at {}, version {}\n", robots->size(),
                              robots->size() == 1 ? "" : "s",
                              run.connect.brokers.front().ToString(), version));
  };
  if (auto ended = simulator::Run(**fleet, run); !ended) return Fail(std::move(ended.error()));
  return ExitCode::kDone;
}

void DeclareRobots(OptionSet& set, Options& o) {
  constexpr const char* kRobots = "Robots";
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    return set.AddOption(names, value, help).Type(type).Group(kRobots);
  };
  set.AddOption("targets", o.targets, "Robots: manufacturer/serialNumber; platforms")
      .Type("TARGET");
  add("--count", o.count, "N", "So many per target, counting up the number at its end [1]");
  add("--vda", o.version, "V", "Version that they speak [3.0.0]").Variable("FLEETPUB_VDA");
  add("--interface", o.interface_name, "NAME",
      "First topic level [uagv up to 2.x, vda5050 from 3.0]")
      .Variable("FLEETPUB_INTERFACE");
  add("--topic-template", o.topic_template, "TEMPLATE",
      "The topic, with its placeholders in braces (see the manual)");
  add("--actions-key", o.actions_key, "KEY", "actions or instantActions: what they expect");
  add("--state-interval", o.state_interval, "TIME",
      "Longest time between two states or statuses [30s]");
  add("--mode", o.mode, "MODE", "Their operatingMode [AUTOMATIC]");
  set.AddFlag("--with-order", o.with_order, "They are under way with an order").Group(kRobots);
  add("--order-time", o.order_time, "TIME", "An order takes so long [until it is cancelled]");
  add("--for", o.duration, "TIME", "End after this time [on Ctrl-C]");
  set.AddFlag("--force", o.force, "Take the place of a robot that is ONLINE").Group(kRobots);
}

void DeclarePlatforms(OptionSet& set, Options& o) {
  set.AddOption("--protocol", o.protocol, "vda5050, or soar: the targets are platforms [vda5050]")
      .Type("NAME")
      .Group("SoAR");
  DeclarePrefix(set, o.prefix);
  set.AddOption("--stop-at", o.stop_at,
                "Acknowledge no further than c2_received, operator_approved_and_sent, executed")
      .Type("LEVEL")
      .Group("SoAR");
}

void DeclareFaults(OptionSet& set, Options& o) {
  constexpr const char* kFaults = "Faults";
  const auto add = [&](const char* names, std::string& value, const char* type, const char* help) {
    set.AddOption(names, value, help).Type(type).Group(kFaults);
  };
  const auto add_types = [&](const char* name, std::vector<std::string>& types, const char* help) {
    set.AddOption(name, types, help).Type("TYPE").OneValueEach().Group(kFaults);
  };
  add("--delay", o.delay, "TIME", "An action takes so long; a platform, from level to level [0]");
  add_types("--fail", o.fail, "Actions of this type end FAILED; repeatable");
  add_types("--reject", o.reject, "Actions of this type are refused; repeatable");
  add("--reject-style", o.reject_style, "STYLE",
      "state: an action state FAILED and an error; error: an error only [state from 3.0]");
  add_types("--retriable", o.retriable, "Actions of this type become RETRIABLE; repeatable");
  add("--list-limit", o.list_limit, "N",
      "So many ended instant actions fit into the list (3.0) [20, then the oldest go]");
  set.AddFlag("--silent", o.silent, "Never report a state; a platform says nothing").Group(kFaults);
  add("--drop", o.drop, "PERCENT", "Ignore this share of the messages [0]");
  add("--seed", o.seed, "N", "Another choice of what is dropped [1]");
}

}  // namespace

Run DeclareSimulate(OptionSet& set) {
  const auto options = std::make_shared<Options>();
  DeclareRobots(set, *options);
  DeclareFaults(set, *options);
  DeclarePlatforms(set, *options);
  return [options](const Context& context) { return RunSimulate(*options, context); };
}

}  // namespace fleetpub::cli
