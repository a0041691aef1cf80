// `fleetpub simulate TARGET…`: virtual robots that answer.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <csignal>
#include <memory>

#include "app/targets.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/commands/soar_simulate.h"
#include "cli/layout_file.h"
#include "cli/options/soar_options.h"
#include "cli/options/vda_options.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config_settings.h"
#include "layout/route.h"
#include "simulator/faults.h"
#include "simulator/runner.h"
#include "simulator/trouble.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/reports/discovery.h"

namespace fleetpub::cli {
namespace {

using vda5050::RobotAddress;
using vda5050::Version;

struct SimulateOptions {
  std::vector<std::string> targets;
  app::VdaOptions vda;
  std::size_t count = 1;
  std::optional<std::chrono::milliseconds> duration;
  std::string mode;
  unsigned battery = 80;
  std::vector<std::string> mode_changes;
  std::vector<std::string> unreachable;
  std::vector<std::string> hang;
  simulator::Settings settings;
  std::vector<std::string> fail;
  std::vector<std::string> reject;
  std::vector<std::string> retriable;
  std::vector<std::string> errors;
  std::optional<std::string> position;
  std::string layout_file;
  bool force = false;

  bool is_soar = false;
  std::string prefix = "soar";
  std::optional<soar::Level> stop_at;
};

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

constexpr auto kModeNames = [] {
  std::array<std::string_view, kModes.size()> names;
  std::transform(kModes.begin(), kModes.end(), names.begin(), [](const Mode& m) { return m.name; });
  return names;
}();

bool HasMode(std::string_view name, Version version) {
  return std::any_of(kModes.begin(), kModes.end(), [&](const Mode& mode) {
    return mode.name == name && version >= mode.first && version <= mode.last;
  });
}

constexpr auto kRejectStyles = std::to_array<base::Choice<simulator::RejectStyle>>({
    {"state", simulator::RejectStyle::kState},
    {"error", simulator::RejectStyle::kError},
});

// What people are shown, and how 2.1's text spells it elsewhere.
constexpr auto kEmergencyStops = std::to_array<base::Choice<std::string_view>>({
    {"AUTOACK", "AUTOACK"},
    {"AUTO_ACK", "AUTOACK"},
    {"MANUAL", "MANUAL"},
    {"REMOTE", "REMOTE"},
    {"NONE", "NONE"},
});

// `pause` → `startPause`; a manufacturer's own type stays as it is.
void AddTypes(const std::vector<std::string>& words, Version version,
              std::set<std::string, std::less<>>& types) {
  for (const std::string& word : words) {
    const auto predefined = vda5050::ActionCalled(word);
    types.emplace(predefined ? vda5050::NameIn(version, *predefined) : std::string_view(word));
  }
}

// As this robot, or each of them, is configured; never `auto`, which is for robots that are there.
app::VdaOptions SpokenBy(const std::vector<RobotAddress>& robots, const SimulateOptions& o,
                         const config::Config& config) {
  app::VdaOptions vda = robots.size() == 1 ? app::WithConfig(o.vda, config, robots.front())
                                           : app::WithConfig(o.vda, config);
  if (vda.IsAutomatic()) vda.version.clear();
  return vda;
}

// `10s:MANUAL`
Result<simulator::ModeChange> ParseModeChange(std::string_view text, Version version) {
  const std::string_view time = text.substr(0, text.find(':'));
  const auto after = base::ParseDuration(time, std::chrono::seconds(1));
  std::string mode(text.substr(std::min(text.size(), time.size() + 1)));
  std::transform(mode.begin(), mode.end(), mode.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (after && HasMode(mode, version)) return simulator::ModeChange{*after, mode};
  return Fail(ErrorKind::kUsage,
              fmt::format("--mode-change takes TIME:MODE, such as 10s:MANUAL, with a mode of VDA "
                          "5050 {}, not '{}'",
                          vda5050::GetFacts(version).name, base::Printable(text)));
}

Status SetModeChanges(const SimulateOptions& o, simulator::Settings& settings) {
  for (const std::string& text : o.mode_changes) {
    auto change = ParseModeChange(text, settings.version);
    if (!change) return Fail(std::move(change.error()));
    settings.mode_changes.push_back(*std::move(change));
  }
  std::stable_sort(settings.mode_changes.begin(), settings.mode_changes.end(),
                   [](const auto& a, const auto& b) { return a.after < b.after; });
  return {};
}

// Where the layout has the node of --at.
Status PlaceOnLayout(const SimulateOptions& o, simulator::RobotState& state, Output& output) {
  if (state.last_node_id.empty()) {
    return Fail(ErrorKind::kUsage, "--layout needs a node to stand on: --at NODE");
  }
  const auto site = LoadLayout(o.layout_file, output);
  if (!site) return Fail(site.error());
  const auto places = layout::ResolvePlace(*site, state.last_node_id);
  if (!places) return Fail(places.error());
  const layout::Node& node = site->nodes[places->front()];
  const double theta = node.properties.empty() ? 0 : node.properties.front().theta.value_or(0);
  state.last_node_id = node.id;
  simulator::PlaceAt({.x = node.x, .y = node.y, .theta = theta, .map_id = node.map_id}, state);
  return {};
}

Status SetTrouble(const SimulateOptions& o, Version version, simulator::RobotState& state,
                  Output& output) {
  if (!simulator::HasEmergencyStop(state.emergency_stop, version)) {
    return Fail(ErrorKind::kUsage,
                fmt::format("--emergency-stop: VDA 5050 {} has MANUAL, REMOTE and NONE, not {}",
                            vda5050::GetFacts(version).name, state.emergency_stop));
  }
  for (const std::string& text : o.errors) {
    auto error = simulator::ParseRobotError(text, version);
    if (!error) return Fail(std::move(error.error()));
    state.errors.push_back(*std::move(error));
  }
  if (!base::IsUtf8(state.last_node_id)) {
    return Fail(ErrorKind::kUsage, "--at: the text is not valid UTF-8");
  }
  if (!o.layout_file.empty()) {
    if (auto ok = PlaceOnLayout(o, state, output); !ok) return ok;
  }
  if (!o.position) return {};
  auto position = simulator::ParsePosition(*o.position);
  if (!position) return Fail(std::move(position.error()));
  simulator::PlaceAt(*std::move(position), state);
  return {};
}

Result<simulator::Settings> MakeSettings(const SimulateOptions& o, const app::VdaOptions& vda,
                                         Output& output) {
  const auto dialect = app::ParseDialect(vda);
  if (!dialect) return Fail(dialect.error());
  simulator::Settings settings = o.settings;
  settings.version = dialect->version;
  settings.topics = dialect->topics;
  settings.actions_key = dialect->actions_key;
  if (!o.mode.empty() && !HasMode(o.mode, settings.version)) {
    return Fail(ErrorKind::kUsage, fmt::format("--mode: VDA 5050 {} has no mode {}",
                                               vda5050::GetFacts(settings.version).name, o.mode));
  }
  if (!o.mode.empty()) settings.operating_mode = o.mode;
  AddTypes(o.fail, settings.version, settings.fail);
  AddTypes(o.reject, settings.version, settings.reject);
  AddTypes(o.retriable, settings.version, settings.retriable);
  AddTypes(o.hang, settings.version, settings.hang);
  settings.unreachable.insert(o.unreachable.begin(), o.unreachable.end());
  settings.initial.battery = o.battery;
  if (auto ok = SetModeChanges(o, settings); !ok) return Fail(std::move(ok.error()));
  if (!settings.retriable.empty() && settings.version < Version::k300) {
    return Fail(ErrorKind::kUsage, "--retriable: RETRIABLE exists from version 3.0.0 on");
  }
  if (settings.list_limit > 0 && settings.version < Version::k300) {
    return Fail(ErrorKind::kUsage,
                "--list-limit: ended actions stay until they are cleared from version 3.0.0 on");
  }
  if (auto ok = SetTrouble(o, settings.version, settings.initial, output); !ok) {
    return Fail(std::move(ok.error()));
  }
  return settings;
}

Result<std::vector<RobotAddress>> Robots(const SimulateOptions& o, const Context& context) {
  const auto targets = app::ResolveRobots(o.targets, context.config, context.output);
  if (!targets) return Fail(targets.error());
  std::vector<RobotAddress> robots;
  for (const RobotAddress& target : *targets) {
    auto some = simulator::CountUp(target, o.count);
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

bool HasTrouble(const SimulateOptions& o) {
  const simulator::RobotState usual;
  const simulator::RobotState& state = o.settings.initial;
  return o.battery != SimulateOptions().battery || state.emergency_stop != usual.emergency_stop ||
         state.field_violation || !state.last_node_id.empty() || !o.errors.empty() || o.position ||
         !o.layout_file.empty();
}

bool Drives(const SimulateOptions& o) {
  const simulator::Settings usual;
  const simulator::Settings& s = o.settings;
  return s.speed != usual.speed || s.time_scale != usual.time_scale ||
         s.edge_time != usual.edge_time || s.order_time != usual.order_time ||
         s.order_limit != usual.order_limit || s.min_state_interval != usual.min_state_interval ||
         s.visualization_interval != usual.visualization_interval || !o.mode_changes.empty() ||
         !o.unreachable.empty() || !o.hang.empty();
}

// What only robots have, and was asked of platforms.
Status RefuseRobotOptions(const SimulateOptions& o) {
  const SimulateOptions none;
  const bool any = !o.vda.interface_name.empty() || !o.vda.topic_template.empty() ||
                   !o.vda.actions_key.empty() || o.count != none.count || !o.mode.empty() ||
                   o.settings.with_order || Drives(o) || o.settings.faults.Any() ||
                   o.settings.list_limit != none.settings.list_limit || !o.fail.empty() ||
                   !o.reject.empty() || !o.retriable.empty() || o.force ||
                   o.settings.reject_style != none.settings.reject_style ||
                   o.settings.drop != none.settings.drop || HasTrouble(o);
  if (!any) return {};
  return Fail(ErrorKind::kUsage,
              "with --protocol soar there are --prefix, --delay, --stop-at, --silent, "
              "--state-interval and --for; the other options are for VDA 5050");
}

Result<ExitCode> RunPlatforms(const SimulateOptions& o, const Context& context) {
  if (auto ok = RefuseRobotOptions(o); !ok) return Fail(ok.error());
  return RunSoarSimulation({.destinations = o.targets,
                            .prefix = o.prefix,
                            .stop_at = o.stop_at,
                            .delay = o.settings.delay.value_or(std::chrono::milliseconds(0)),
                            .status_interval = o.settings.state_interval,
                            .duration = o.duration,
                            .silent = o.settings.silent,
                            .stopped = [] { return g_stopped != 0; },
                            .on_ready = StopOnSignals},
                           context);
}

// A fault of an action that nobody will send shows nothing.
void WarnOfMisspelt(const SimulateOptions& o, Output& output) {
  for (const auto* words : {&o.fail, &o.reject, &o.retriable, &o.hang}) {
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

Result<ExitCode> RunSimulate(const SimulateOptions& o, const Context& context) {
  if (o.is_soar) return RunPlatforms(o, context);
  if (o.stop_at) return Fail(ErrorKind::kUsage, "--stop-at belongs to --protocol soar");
  Output& output = context.output;
  const auto robots = Robots(o, context);
  if (!robots) return Fail(robots.error());
  auto settings = MakeSettings(o, SpokenBy(*robots, o, context.config), context.output);
  if (!settings) return Fail(std::move(settings.error()));
  const vda5050::TopicScheme topics = settings->topics;
  const std::string_view version = vda5050::GetFacts(settings->version).name;
  schema::Registry registry(context.options.schema_directory);
  WarnOfMisspelt(o, output);
  const auto fleet =
      simulator::Fleet::Make(*std::move(settings), *robots, registry,
                             [&](std::string_view robot, const simulator::Event& event) {
                               ShowEvent(robot, event, output);
                             });
  if (!fleet) return Fail(fleet.error());
  auto connect = MakeConnectOptions(context);
  if (!connect) return Fail(std::move(connect.error()));

  simulator::RunOptions run{.connect = *std::move(connect)};
  run.connect.properties = {};  // they are a command's; what a robot is does not expire
  run.duration = o.duration;
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
                    "dropped it, or this login may not read it; over -V 5 a broker can say "
                    "no",
                    base::Printable(topic)));
  };
  run.on_arrival = StopOnSignals;
  run.on_ready = [&] {
    Print(stderr, fmt::format("fleetpub: {} online at {}, version {}\n",
                              base::Counted(robots->size(), "robot"),
                              run.connect.brokers.front().ToString(), version));
  };
  if (auto ended = simulator::Run(**fleet, run); !ended) return Fail(std::move(ended.error()));
  return ExitCode::kDone;
}

ValueKind Decimal(double& value, double least, double most, const char* takes) {
  return {.type = "N",
          .store =
              [&value, least, most](const std::vector<std::string>& texts) {
                const auto number = ParseBetween<double>(texts.front(), least, most);
                if (number) value = *number;
                return number.has_value();
              },
          .takes = [takes] { return std::string(takes); }};
}

ValueKind FaultNames(simulator::Faults& faults) {
  return {.type = "NAME",
          .store =
              [&faults](const std::vector<std::string>& names) {
                for (const std::string& name : names) {
                  const auto fault = simulator::FindFault(name);
                  if (!fault) return false;
                  faults.Add(*fault);
                }
                return true;
              },
          .choices =
              [] {
                std::vector<std::string_view> names;
                for (const auto& fault : simulator::ListFaults()) names.push_back(fault.name);
                return names;
              },
          .is_list = true};
}

void DeclareRobots(OptionSet& set, SimulateOptions& o) {
  constexpr const char* kRobots = "Robots";
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group(kRobots);
  };
  set.AddOption("targets", o.targets, "Robots: manufacturer/serialNumber; platforms")
      .Type("TARGET");
  add("--count", WholeNumber(o.count, 1, 100'000), "N",
      "So many per target, counting up the number at its end [1]");
  add("--vda", VdaVersion(o.vda.version, Automatic::kNo), "V", "Version that they speak [3.0.0]")
      .Variable("FLEETPUB_VDA");
  add("--interface", Text(o.vda.interface_name), "NAME",
      "First topic level [uagv up to 2.x, vda5050 from 3.0]")
      .Variable("FLEETPUB_INTERFACE");
  add("--topic-template", Text(o.vda.topic_template), "TEMPLATE",
      "The topic, with its placeholders in braces (see the manual)");
  add("--actions-key", OneOf(o.vda.actions_key, config::kActionsKeys), "KEY",
      "{}: what they expect");
  add("--state-interval", Interval(o.settings.state_interval), "TIME",
      "Longest time between two states or statuses [30s]");
  ValueKind mode = OneOf(o.mode, kModeNames);
  mode.exists_in = HasMode;
  add("--mode", std::move(mode), "MODE", "Their operatingMode [AUTOMATIC]");
  set.AddFlag("--with-order", o.settings.with_order, "They are under way with an order")
      .Group(kRobots);
  add("--mode-change", Text(o.mode_changes), "TIME:MODE",
      "Somebody switches them to this mode after that time; repeatable")
      .OneValueEach();
  add("--for", Duration(o.duration), "TIME", "End after this time [on Ctrl-C]");
  set.AddFlag("--force", o.force, "Take the place of a robot that is ONLINE").Group(kRobots);
}

void DeclareDriving(OptionSet& set, SimulateOptions& o) {
  constexpr const char* kDriving = "Driving";
  simulator::Settings& settings = o.settings;
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group(kDriving);
  };
  add("--speed", Decimal(settings.speed, 0.001, 1000, "a speed in m/s such as 1.5"), "M/S",
      "How fast they drive at most, in m/s [1]");
  add("--time-scale", Decimal(settings.time_scale, 0.001, 1e6, "a number above 0 such as 10"), "N",
      "Driving, actions and battery go so many times as fast [1]");
  add("--edge-time", Interval(settings.edge_time), "TIME",
      "An edge of unknown length takes so long [2s]");
  add("--order-time", Duration(settings.order_time), "TIME",
      "All edges of an order take so long, whatever their length [as --speed says]");
  add("--visualization-interval", Interval(settings.visualization_interval), "TIME",
      "Time between two messages on visualization [none]");
  add("--min-state-interval", Duration(settings.min_state_interval), "TIME",
      "Shortest time between two states [0]");
  add("--order-limit", WholeNumber(settings.order_limit, 1, 1'000'000), "N",
      "An order of more nodes is too large for them [any number fits]");
  add("--unreachable", Text(o.unreachable), "NODE", "No way leads to this node; repeatable")
      .OneValueEach();
}

void DeclareTrouble(OptionSet& set, SimulateOptions& o) {
  constexpr const char* kTrouble = "Trouble";
  simulator::RobotState& state = o.settings.initial;
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    return set.AddOption(names, std::move(kind), help).Type(type).Group(kTrouble);
  };
  add("--battery", WholeNumber(o.battery, 0, 100), "PERCENT", "Their charge [80]");
  add("--error", Text(o.errors), "TYPE:LEVEL[:TEXT]",
      "They have this error: motorFault:FATAL:'motor 2 hot'; repeatable")
      .OneValueEach();
  set.AddFlag("--emergency-stop", OneOf(state.emergency_stop, kEmergencyStops), "MANUAL",
              "They stand in emergency stop; --emergency-stop=REMOTE says who acknowledges it: {}")
      .Group(kTrouble);
  set.AddFlag("--field-violation", state.field_violation, "Something is in the protective field")
      .Group(kTrouble);
  add("--position", Text(o.position), "X,Y,THETA[,MAP]",
      "Where they are [0,0,0,map-1, until an order begins elsewhere]");
  add("--at", Text(state.last_node_id), "NODE", "The last node that they passed");
  add("--layout", Text(o.layout_file), "FILE", "A layout (LIF), which says where that node is");
}

void DeclarePlatforms(OptionSet& set, SimulateOptions& o) {
  set.AddOption("--protocol", OneOf(o.is_soar, kProtocols),
                "{}: with soar the targets are platforms [vda5050]")
      .Type("NAME")
      .Group("SoAR");
  DeclarePrefix(set, o.prefix);
  set.AddOption("--stop-at", OneOf(o.stop_at, soar::kLevels), "Acknowledge no further than {}")
      .Type("LEVEL")
      .Group("SoAR");
}

void DeclareFaults(OptionSet& set, SimulateOptions& o) {
  constexpr const char* kFaults = "Faults";
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    set.AddOption(names, std::move(kind), help).Type(type).Group(kFaults);
  };
  const auto add_types = [&](const char* name, std::vector<std::string>& types, const char* help) {
    set.AddOption(name, types, help).Type("TYPE").OneValueEach().Group(kFaults);
  };
  add("--delay", Duration(o.settings.delay), "TIME",
      "An action takes so long; a platform, from level to level [0; in an order 200ms]");
  add_types("--fail", o.fail, "Actions of this type end FAILED; repeatable");
  add_types("--reject", o.reject, "Actions of this type are refused; repeatable");
  add_types("--hang", o.hang, "An order's actions of this type never end; repeatable");
  add("--reject-style", OneOf(o.settings.reject_style, kRejectStyles), "STYLE",
      "state: an action state FAILED and an error; error: an error only [state from 3.0]");
  add_types("--retriable", o.retriable, "Actions of this type become RETRIABLE; repeatable");
  add("--list-limit", WholeNumber(o.settings.list_limit, 0, 10'000), "N",
      "So many ended instant actions fit into the list (3.0) [20, then the oldest go]");
  set.AddFlag("--silent", o.settings.silent, "Never report a state; a platform says nothing")
      .Group(kFaults);
  set.AddOption("--fault", FaultNames(o.settings.faults),
                "They break the specification; repeatable. See the manual: {}")
      .Type("NAME")
      .OneValueEach()
      .Group(kFaults);
  add("--drop", Percentage(o.settings.drop), "PERCENT", "Ignore this share of the messages [0]");
  add("--seed", WholeNumber(o.settings.drop_seed), "N", "Another choice of what is dropped [1]");
}

}  // namespace

Run DeclareSimulate(OptionSet& set) {
  const auto options = std::make_shared<SimulateOptions>();
  DeclareRobots(set, *options);
  DeclareDriving(set, *options);
  DeclareTrouble(set, *options);
  DeclareFaults(set, *options);
  DeclarePlatforms(set, *options);
  return [options](const Context& context) { return RunSimulate(*options, context); };
}

}  // namespace fleetpub::cli
