#include "cli/parser/shell_completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <set>
#include <span>

#include "app/recent_targets.h"
#include "base/text.h"
#include "cli/output/output.h"
#include "cli/parser/command_line.h"
#include "layout/layout.h"
#include "ledger/postgres/postgres_url.h"
#include "schema/schema.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::cli {
namespace {

/// A command line, as far as it is typed.
struct Typed {
  CommandLine call;
  std::vector<std::string> before;  ///< the whole words
  std::string current;
};

using Source = void (*)(const Typed& typed, Candidates& found);

template <const auto& kWords>
void Fixed(const Typed& /*typed*/, Candidates& found) {
  for (const std::string_view word : kWords) found.words.push_back({std::string(word), ""});
}

void Files(const Typed& /*typed*/, Candidates& found) { found.files = true; }

void Profiles(const Typed& typed, Candidates& found) {
  for (const auto& [name, settings] : typed.call.config.profiles) {
    found.words.push_back({name, "profile"});
  }
}

void ActionTypes(const Typed& /*typed*/, Candidates& found) {
  for (const std::string_view type : vda5050::AllActionNames()) {
    if (!vda5050::IsEverInstant(type)) continue;
    const auto* action = vda5050::FindAction(vda5050::kVersions.back(), type);
    found.words.push_back({std::string(type), std::string(action->summary)});
  }
}

// Also those that only orders hold.
void ActionNames(const Typed& /*typed*/, Candidates& found) {
  for (const std::string_view word : vda5050::AllActionWords()) {
    found.words.push_back({std::string(word), ""});
  }
}

void SchemaNames(const Typed& typed, Candidates& found) {
  const schema::Registry registry(typed.call.options.schema_directory);
  for (const auto& [name, origin] : registry.List()) found.words.push_back({name, origin});
}

// Of a ledger in a file only: completion connects to nothing.
std::vector<std::string> Commanded(const Typed& typed, std::string_view protocol) {
  if (ledger::IsUrl(typed.call.options.ledger)) return {};
  Output quiet({.quiet = true});
  const Context context{typed.call.options, quiet, typed.call.config};
  return app::FindRecentTargets([&](ledger::OpenMode mode) { return OpenLedger(context, mode); },
                                protocol);
}

void Robots(const Typed& typed, Candidates& found) {
  const config::Config& config = typed.call.config;
  for (const auto& [alias, robot] : config.aliases) {
    found.words.push_back({alias, robot.ToString()});
  }
  std::set<std::string> seen;
  for (const auto& [robot, configured] : config.robots) {
    seen.insert(robot.ToString());
    found.words.push_back({robot.ToString(), "configured"});
  }
  for (const std::string& target : Commanded(typed, "vda5050")) {
    const auto robot = vda5050::ParseRobotAddress(target);
    if (!robot || robot->ToString() != target) continue;  // it would mean something else
    if (seen.insert(target).second) found.words.push_back({target, "commanded before"});
  }
}

void TargetNames(const Typed& typed, Candidates& found) {
  Robots(typed, found);
  for (const auto& [group, robots] : typed.call.config.group_robots) {
    found.words.push_back({"@" + group, fmt::format("group of {}", robots.size())});
  }
}

void Destinations(const Typed& typed, Candidates& found) {
  for (const std::string& target : Commanded(typed, "soar")) {
    found.words.push_back({target, "commanded before"});
  }
}

// `action TYPE -P`: what that type takes.
void Parameters(const Typed& typed, Candidates& found) {
  const auto& arguments = typed.call.match.arguments;
  const auto words = WordPositions(typed.call.set(), arguments);
  if (typed.call.match.name != "action" || words.empty()) return;
  for (const auto& parameter : vda5050::ParametersInAnyVersion(arguments[words.front()])) {
    const bool text = parameter.type == vda5050::ParameterType::kString;
    found.words.push_back(
        {fmt::format("{}{}", parameter.name, text ? "=" : ":="), std::string(parameter.meaning)});
  }
}

// The layout that the command would take: of an option, of its words, or the configuration's.
std::optional<layout::Site> FindLayout(const Typed& typed) {
  const OptionSet& set = typed.call.set();
  std::string file;
  if (const Option option = set.Find("--layout"); option.exists() && option.IsGiven()) {
    file = option.texts().front();
  } else if (const Option word = set.Find("file"); word.exists() && word.IsGiven()) {
    file = word.texts().front();
  } else if (const auto* const configured = typed.call.config.Find("layout")) {
    file = configured->texts.front();
  }
  if (file.empty() || file == "-") return std::nullopt;  // standard input is the shell's
  auto read = layout::ReadLayoutFile(file);
  if (!read) return std::nullopt;
  return std::move(read->site);
}

// Stations first: there are few of them.
void LayoutPlaces(const Typed& typed, Candidates& found) {
  const auto site = FindLayout(typed);
  if (!site) return;
  for (const auto& station : site->stations) {
    found.words.push_back({station.id, station.name.empty() ? "station" : station.name});
  }
  for (const auto& node : site->nodes) {
    found.words.push_back({node.id, node.name.empty() ? "node" : node.name});
  }
}

void VehicleTypes(const Typed& typed, Candidates& found) {
  const auto site = FindLayout(typed);
  if (!site) return;
  for (const std::string& type : site->VehicleTypes()) {
    found.words.push_back({type, "vehicle type"});
  }
}

struct Slot {
  std::string_view command;  ///< empty: of any command
  std::string_view name;     ///< an option's long name, or a positional one
  Source source;
};

// Beside the options that list their choices. The first that fits counts.
constexpr auto kOptionValues = std::to_array<Slot>({
    {"simulate", "reject", ActionTypes},
    {"simulate", "fail", ActionTypes},
    {"simulate", "retriable", ActionTypes},
    {"layout", "from", LayoutPlaces},
    {"layout", "to", LayoutPlaces},
    {"layout", "via", LayoutPlaces},
    {"layout", "vehicle-type", VehicleTypes},
    {"order", "from", LayoutPlaces},
    {"order", "to", LayoutPlaces},
    {"order", "via", LayoutPlaces},
    {"order", "vehicle-type", VehicleTypes},
    {"simulate", "at", LayoutPlaces},
    {"", "topic", Fixed<vda5050::kTopicNames>},
    {"", "profile", Profiles},
    {"", "target", Robots},
    {"", "except", TargetNames},
    {"", "action", ActionTypes},
    {"", "parameter", Parameters},
});

constexpr auto kPositions = std::to_array<Slot>({
    {"await", "topic", Fixed<vda5050::kReportTopics>},
    {"schema show", "name", SchemaNames},
    {"action", "type", ActionTypes},
    {"actions", "name", ActionNames},
    {"order", "nodes", LayoutPlaces},
    {"", "targets", TargetNames},
    {"", "target", Robots},
    {"", "destination", Destinations},
    {"", "file", Files},
    {"", "place", Files},
});

// The version that the typed command would speak; none: it is not known yet.
std::optional<vda5050::Version> FindVersion(const Typed& typed) {
  const OptionSet& set = typed.call.set();
  const config::ConfigValue* const configured = typed.call.config.Find("vda");
  const auto parse = [](std::string_view text) -> std::optional<vda5050::Version> {
    const auto version = vda5050::ParseVersion(text);
    return version ? std::optional(*version) : std::nullopt;
  };
  if (const Option option = set.Find("--vda"); option.IsGiven()) {
    return parse(option.texts().front());
  }
  return configured != nullptr ? parse(configured->texts.front()) : vda5050::kVersions.back();
}

// Of an option that lists its choices; false: it has none.
bool ListChoices(const Option& option, const Typed& typed, Candidates& found) {
  const auto choices = option.Choices(FindVersion(typed));
  for (const std::string_view choice : choices) found.words.push_back({std::string(choice), ""});
  return !choices.empty();
}

bool Fits(const Slot& slot, std::string_view command, std::string_view name) {
  return slot.name == name && (slot.command.empty() || command == slot.command ||
                               command.starts_with(std::string(slot.command) + " "));
}

void Ask(std::span<const Slot> slots, std::string_view name, const Typed& typed,
         Candidates& found) {
  const auto slot = std::find_if(slots.begin(), slots.end(), [&](const Slot& candidate) {
    return Fits(candidate, typed.call.match.name, name);
  });
  if (slot != slots.end()) slot->source(typed, found);
}

void AddCommand(std::string_view name, std::string_view meaning, Candidates& found) {
  const bool known = std::any_of(found.words.begin(), found.words.end(),
                                 [&](const Candidate& word) { return word.text == name; });
  if (!known) found.words.push_back({std::string(name), std::string(meaning)});
}

// The first words of all commands, those of every day first.
void Commands(const Typed& typed, Candidates& found) {
  for (const EverydayCommand& command : EverydayCommands()) {
    AddCommand(command.name, command.summary, found);
  }
  Candidates types;
  ActionTypes(typed, types);
  for (const Candidate& type : types.words) AddCommand(type.text, type.meaning, found);
  for (const std::string_view type : vda5050::AllActionNames()) {
    if (!vda5050::IsEverInstant(type)) continue;
    for (const std::string_view name : vda5050::ListShortNames(type)) AddCommand(name, type, found);
  }
  for (const Subcommand& subcommand : Subcommands()) {
    const std::size_t blank = subcommand.name.find(' ');
    const std::string_view first = subcommand.name.substr(0, blank);
    const CommandFamily* const family = FindCommandFamily(first);
    AddCommand(first, family != nullptr ? family->summary : subcommand.summary, found);
  }
}

// `schema` → list, show.
void SecondWords(std::string_view first, Candidates& found) {
  const std::string beginning = std::string(first) + " ";
  for (const Subcommand& subcommand : Subcommands()) {
    if (!subcommand.name.starts_with(beginning)) continue;
    AddCommand(subcommand.name.substr(beginning.size()), subcommand.summary, found);
  }
}

// Of several names of one option the first that continues what is typed.
void OptionNames(const Typed& typed, Candidates& found) {
  for (const Option& option : typed.call.set().options()) {
    std::vector<std::string> words;
    for (const std::string& name : option.long_names()) words.push_back("--" + name);
    const bool is_given = std::any_of(words.begin(), words.end(), [&](const std::string& word) {
      return std::find(typed.before.begin(), typed.before.end(), word) != typed.before.end();
    });
    const auto word = std::find_if(words.begin(), words.end(), [&](const std::string& candidate) {
      return candidate.starts_with(typed.current);
    });
    if (word == words.end() || (is_given && !option.IsRepeatable())) continue;
    found.words.push_back({*word, option.description()});
  }
}

void OptionValues(const Option& option, const Typed& typed, Candidates& found) {
  if (ListChoices(option, typed, found)) return;
  const std::string type = option.type();
  if (type == "FILE" || type == "FOLDER") return Files(typed, found);
  if (!option.long_names().empty()) {
    Ask(kOptionValues, option.long_names().front(), typed, found);
  }
}

// What stands in the place of the current word, which is no option.
void Words(const Typed& typed, Candidates& found) {
  const OptionSet& set = typed.call.set();
  const SubcommandMatch& match = typed.call.match;
  if (match.name.empty()) {
    const auto words = WordPositions(set, typed.before);
    return words.empty() ? Commands(typed, found) : SecondWords(typed.before[words.front()], found);
  }
  std::size_t place = WordPositions(set, match.arguments).size();
  if (place == 0) SecondWords(match.name, found);
  for (const Option& option : set.options()) {
    if (!option.IsPositional()) continue;
    if (place == 0 || option.IsRepeatable()) {
      if (ListChoices(option, typed, found)) return;
      return Ask(kPositions, option.position_name(), typed, found);
    }
    --place;
  }
}

void Read(Typed& typed) {
  // An option whose value is still being typed would be the only thing that is seen.
  const bool open = !typed.before.empty() && typed.before.back().starts_with('-');
  const std::vector<std::string> whole(typed.before.begin(), typed.before.end() - (open ? 1 : 0));
  const auto asked = typed.call.Read(OptionSet::Extent::kAll, whole);
  if (asked && *asked != OptionSet::Asked::kRun) return;  // what is declared is enough
  static_cast<void>(typed.call.Configure());
}

}  // namespace

Candidates CandidatesFor(std::vector<std::string> words) {
  Typed typed;
  if (!words.empty()) {
    typed.current = std::move(words.back());
    words.pop_back();
  }
  typed.before = std::move(words);
  Read(typed);

  Candidates found;
  const OptionSet& set = typed.call.set();
  const std::size_t equals = typed.current.find('=');
  std::string prefix;  // `--vda=` of `--vda=2`
  if (typed.current.starts_with("--") && equals != std::string::npos) {
    prefix = typed.current.substr(0, equals + 1);
    const std::string name = typed.current.substr(0, equals);
    if (set.IsDeclared(name)) OptionValues(set.Find(name), typed, found);
  } else if (!typed.before.empty() && typed.before.back().starts_with('-') &&
             TakesNext(set, typed.before.back())) {
    const std::string& last = typed.before.back();
    const std::string name = last.starts_with("--") ? last : std::string("-") + last.back();
    OptionValues(set.Find(name), typed, found);
  } else if (typed.current.starts_with('-')) {
    OptionNames(typed, found);
  } else {
    Words(typed, found);
  }
  for (Candidate& word : found.words) word.text.insert(0, prefix);
  std::erase_if(found.words, [&](const Candidate& word) {
    return !word.text.starts_with(typed.current) || base::Printable(word.text) != word.text;
  });
  return found;
}

ExitCode PrintCandidates(const std::vector<std::string>& arguments) {
  const Candidates found = CandidatesFor({arguments.begin() + 1, arguments.end()});
  for (const Candidate& word : found.words) {
    Print(stdout, fmt::format("{}\t{}\n", word.text, base::Printable(word.meaning)));
  }
  if (found.files) Print(stdout, ":files\n");
  return ExitCode::kDone;
}

}  // namespace fleetpub::cli
