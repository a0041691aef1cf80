// The table of subcommands. Predefined actions are not in it: they come from the catalogue.
#include <algorithm>
#include <array>

#include "base/text.h"
#include "cli/parser/subcommand.h"
#include "vda5050/catalogue/catalogue.h"

namespace fleetpub::cli {
namespace {

using enum HelpGroup;

constexpr auto kSubcommands = std::to_array<Subcommand>({
    {"action", kRobots, "TYPE TARGET...", "send any instant action, such as a manufacturer's own",
     "action beep KIT/0001 -P duration:=3 -P mode=loud\n"
     "action beep 'KIT/*' --except KIT/0001 --where 'battery>20' --yes\n"
     "action customScan KIT/0001 KIT/0002 -P area:=@area.json --wait",
     DeclareAction},
    {"order", kRobots, "TARGET [NODE...]", "send a robot along nodes or to a place",
     "order KIT/0001 n1 n2 n7\n"
     "order KIT/0001 --to dock-3 --wait\n"
     "order KIT/0001 --to dock-3 --via n4 --action pick@dock-3 loadType=EPAL\n"
     "order KIT/0001 --route tour.csv --release 3 --auto-release --wait",
     DeclareOrder},
    {"order extend", kRobots, "TARGET [NODE...]", "add nodes to the order that a robot has",
     "order extend KIT/0001 n8 n9\n"
     "order extend KIT/0001 --to dock-4 --wait",
     DeclareOrderExtend},
    {"order release", kRobots, "TARGET [N]", "let a robot drive on into its order's horizon",
     "order release KIT/0001 2\n"
     "order release KIT/0001 all",
     DeclareOrderRelease},
    {"order replace", kRobots, "TARGET [NODE...]", "cancel a robot's order and send another",
     "order replace KIT/0001 --to n1 --wait", DeclareOrderReplace},
    {"order follow", kLooking, "TARGET", "tell node by node how far a robot has come",
     "order follow KIT/0001", DeclareOrderFollow},
    {"publish", kRobots, "TOPIC TARGET...", "send a prepared order, zoneSet, responses message ...",
     "publish order KIT/0001 -f order.json --wait\n"
     "publish zoneSet KIT/0001 KIT/0002 -f hall-1.json\n"
     "publish order KIT/0001 -f - --wait-for finished < order.json",
     DeclarePublish},
    {"respond", kRobots, "TARGET REQUEST ANSWER",
     "answer a robot's request: GRANTED, QUEUED, REVOKED, REJECTED",
     "respond KIT/0001 request-1 GRANTED --lease-expiry 30s\n"
     "respond KIT/0001 request-1 REVOKED --wait",
     DeclareRespond},
    {"batch", kRobots, "[FILE]", "many commands, one JSON object per line; so the results",
     "batch commands.jsonl --wait\n"
     "batch --rate 50 --stop-on-error < commands.jsonl\n"
     "batch <<< '{\"target\":\"KIT/0001\",\"action\":\"startPause\"}'",
     DeclareBatch},
    {"requests", kLooking, "[TARGET...]", "what robots ask for: zones and corridors, from 3.0",
     "requests\n"
     "requests 'KIT/*' -o json",
     DeclareRequests},
    {"soar mission-plan", kSoar, "DESTINATION", "what the autonomy engine wants a platform to do",
     "soar mission-plan soar.planet-ocean.ecosub.eco1 --plan-id 3 --platform-id 1 "
     "--waypoint lat=50.3707,lon=-4.1872,depth=15,action=move --wait\n"
     "soar mission-plan soar.noc.autosub.ah1 --plan-id 4 --platform-id 2 --plan route.geojson",
     DeclareSoarMissionPlan},
    {"soar planning-configuration", kSoar, "DESTINATION",
     "squads, platforms and zones to plan with",
     "soar planning-configuration autonomy_engine --file squads.toml\n"
     "soar planning-configuration --broadcast --file squads.json --strict",
     DeclareSoarPlanningConfiguration},
    {"soar acknowledge", kSoar, "DESTINATION", "how far a message has come",
     "soar acknowledge soar.noc.autosub.ah1 --message-id ID --status executed",
     DeclareSoarAcknowledge},
    {"soar observation", kSoar, "DESTINATION", "what a platform has found",
     "soar observation soar.noc.autosub.ah1 --platform-id 2 --point "
     "lat=50.37,lon=-4.19,quality=0.98",
     DeclareSoarObservation},
    {"soar platform-status", kSoar, "DESTINATION", "where a platform is and how it does",
     "soar platform-status soar.noc.autosub.ah1 --platform-id 2 --status-source onboard_platform "
     "--latitude 50.37 --longitude -4.19 --battery 80",
     DeclareSoarPlatformStatus},
    {"fleet", kLooking, "[TARGET...]", "the robots known to the broker, and how they are",
     "fleet\n"
     "fleet --ask\n"
     "fleet 'KIT/*' @hall-1 -o json",
     DeclareFleet},
    {"show", kLooking, "TARGET...", "all that is known of a robot, now; several in short",
     "show KIT/0001\n"
     "show 'KIT/*' --where 'battery<20'\n"
     "show KIT/0001 --no-ask -o json",
     DeclareShow},
    {"watch", kLooking, "[TARGET...]", "the robots and how they are, live",
     "watch\nwatch 'KIT/*' --for 1m -o json", DeclareWatch},
    {"await", kLooking, "TARGET [TOPIC] CONDITION...", "wait until robots' messages say so",
     "await KIT/0001 paused=true\n"
     "await KIT/0001 'battery>=80' charging=false -W 2h\n"
     "await KIT/0001 connection connectionState=ONLINE\n"
     "await 'KIT/*' paused=true",
     DeclareAwait},
    {"tail", kLooking, "[TARGET...]", "what robots and fleet controls say, a line per message",
     "tail 'KIT/*' --topic state --changes\n"
     "tail KIT/0001 -o json\n"
     "tail --filter 'soar/#'\n"
     "tail KIT/0001 --from shift.jsonl",
     DeclareTail},
    {"record", kLooking, "[TARGET...]", "write down what is said, byte for byte",
     "record 'KIT/*' -f shift.jsonl --for 8h\n"
     "record -f hall.jsonl.zst --rotate 1h\n"
     "record --filter 'soar/#' -f sea.jsonl",
     DeclareRecord},
    {"explain", kLooking, "TARGET", "what became of an order or action, now or in a recording",
     "explain KIT/0001\n"
     "explain KIT/0001 --from shift.jsonl\n"
     "explain KIT/0001 --order o-17 --from shift.jsonl -o json\n"
     "explain KIT/0001 --action a-3 --from shift.jsonl",
     DeclareExplain},
    {"conform", kLooking, "TARGET", "does a robot keep the standard? by listening, asking, driving",
     "conform KIT/0001\n"
     "conform KIT/0001 --level actions --report junit=out.xml,html=out.html\n"
     "conform KIT/0001 --level drive --distance 3 --record test.jsonl\n"
     "conform --list",
     DeclareConform},
    {"actions", kLooking, "[NAME]", "the predefined actions, or all about one of them",
     "actions\n"
     "actions initPosition\n"
     "actions --vda 2.1 -o json",
     DeclareActions},
    {"history", kLooking, "[TARGET...]", "what was sent: when, by whom, to which robot",
     "history\n"
     "history KIT/0001 --since yesterday\n"
     "history 'KIT/*' --since 22:00 --status FAILED\n"
     "history show 42\n"
     "history prune --older-than 90d",
     DeclareHistory},
    {"history show", kLooking, "ID", "one sent message, whole", "history show 42",
     DeclareHistoryShow},
    {"history prune", kLooking, "", "remove old rows; header ids stay",
     "history prune --older-than 90d", DeclareHistoryPrune},
    {"validate", kChecking, "[FILE...]", "check messages against a built-in schema or a given one",
     "validate message.json\n"
     "validate --vda 2.1 --topic instantActions message.json\n"
     "validate orders/ --body --vda 2.1\n"
     "validate --lines -o json < messages.jsonl\n"
     "validate --schema my.schema.json message.json\n"
     "validate --protocol soar --message-type mission_plan plan.json",
     DeclareValidate},
    {"layout check", kChecking, "[FILE...]", "all that is wrong or odd in layouts (LIF)",
     "layout check hall.lif.json\n"
     "layout check *.lif.json -o json\n"
     "layout check hall.lif.json --vda 2.1 --factsheet kit.json",
     DeclareLayoutCheck},
    {"layout show", kChecking, "[FILE]", "what a layout holds: levels, vehicle types, stations",
     "layout show hall.lif.json\n"
     "layout show --profile north -o json",
     DeclareLayoutShow},
    {"layout route", kChecking, "[FILE]", "the cheapest way for a vehicle through a layout",
     "layout route hall.lif.json --from n1 --to dock-3\n"
     "layout route hall.lif.json --from n1 --via n4 --to dock-3 --vehicle-type KIT.tug --loaded\n"
     "layout route --from n1 --to dock-3 --by time -o json",
     DeclareLayoutRoute},
    {"schema list", kChecking, "", "all schemas, by name", "schema list", DeclareSchemaList},
    {"schema show", kChecking, "NAME", "print a schema",
     "schema show vda5050/3.0.0/instantActions\n"
     "schema show output/result",
     DeclareSchemaShow},
    {"simulate", kChecking, "TARGET...", "virtual robots that answer, with faults on demand",
     "simulate KIT/0001\n"
     "simulate KIT/0001 --count 100 --vda 2.1 --state-interval 5s\n"
     "simulate KIT/0001 --delay 3s --fail startCharging --reject pause\n"
     "simulate KIT/0001 --battery 15 --error motorFault:FATAL --emergency-stop\n"
     "simulate --protocol soar soar.planet-ocean.ecosub.eco1 --delay 3s",
     DeclareSimulate},
    {"replay", kChecking, "FILE", "say again what robots of a recording said",
     "replay shift.jsonl --map KIT/0001=TEST/0001\n"
     "replay shift.jsonl --speed 4 --restamp --map KIT/0001=TEST/0001",
     DeclareReplay},
    {"test", kChecking, "FILE...", "play scenarios of your own, for smoke tests in CI",
     "test smoke.toml\n"
     "test tests/*.toml --report junit=out.xml -b mqtt://localhost:1883\n"
     "test smoke.toml --only pause --record smoke.jsonl\n"
     "test --check smoke.toml",
     DeclareTest},
    {"config show", kChecking, "", "the settings in force, and where each comes from",
     "config show\n"
     "config show --profile north -o json",
     DeclareConfigShow},
    {"config check", kChecking, "", "all that is wrong in the configuration, with its place",
     "config check\n"
     "config check --config site.toml -o json",
     DeclareConfigCheck, ConfigUse::kNone},
    {"config path", kChecking, "", "the files that are read, in their order", "config path",
     DeclareConfigPath, ConfigUse::kNone},
    {"config profiles", kChecking, "", "the sites that the configuration names",
     "config profiles\n"
     "config profiles -o json",
     DeclareConfigProfiles},
    {"config init", kChecking, "", "write a commented configuration to begin with",
     "config init\n"
     "config init --stdout",
     DeclareConfigInit, ConfigUse::kNone},
    {"completion", kChecking, "SHELL", "the script by which bash, zsh or fish completes fleetpub",
     "completion bash > ~/.local/share/bash-completion/completions/fleetpub\n"
     "completion fish > ~/.config/fish/completions/fleetpub.fish",
     DeclareCompletion, ConfigUse::kNone},
    {"ledger status", kChecking, "", "where header ids and history are kept, and how much of them",
     "ledger status\n"
     "ledger status --ledger postgresql://operator@db.example/fleet -o json",
     DeclareLedgerStatus},
    {"ledger migrate", kChecking, "", "make the ledger's tables, or bring them up to date",
     "ledger migrate\n"
     "ledger migrate --ledger postgresql://owner@db.example/fleet",
     DeclareLedgerMigrate},
    {"ping", kChecking, "", "can the broker be reached, and what does it grant",
     "ping\n"
     "ping --wait 20s\n"
     "ping -b mqtt://broker.example:1883 -u operator --password-file pw",
     DeclarePing},
    {"doctor", kChecking, "[TARGET...]", "what is wrong with settings, broker and fleet",
     "doctor\n"
     "doctor 'KIT/*' --for 5m\n"
     "doctor --profile north --quiet\n"
     "doctor --from shift.jsonl -o json",
     DeclareDoctor, ConfigUse::kExamined},
});

constexpr auto kFamilies = std::to_array<CommandFamily>({
    {"config", "settings in force, where from, and a first file"},
    {"layout", "layouts of sites (LIF), and ways through them"},
    {"ledger", "where header ids and history are kept"},
    {"schema", "the schemas that messages are checked against"},
    {"soar", "messages of the SoAR backbone"},
});

struct Everyday {
  std::string_view title;
  std::string_view name;
};
// A name that is no command yet is passed over.
constexpr auto kEveryday = std::to_array<Everyday>({
    {"Look", "fleet"},
    {"Look", "show"},
    {"Look", "watch"},
    {"Look", "history"},
    {"Command", "pause"},
    {"Command", "resume"},
    {"Command", "cancel"},
    {"Command", "charge"},
    {"Command", "initPosition"},
    {"Command", "order"},
    {"Set up", "doctor"},
    {"Set up", "config"},
    {"Set up", "simulate"},
});

template <class Table>
auto FindNamed(const Table& table, std::string_view name) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& entry) {
    return base::EqualsIgnoringCase(entry.name, name);
  });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace

std::string_view FullName(std::string_view word) {
  return base::EqualsIgnoringCase(word, "status") ? "show" : word;
}

std::span<const Subcommand> Subcommands() { return kSubcommands; }

const Subcommand* FindSubcommandNamed(std::string_view name) {
  return FindNamed(kSubcommands, FullName(name));
}

const CommandFamily* FindCommandFamily(std::string_view word) { return FindNamed(kFamilies, word); }

std::vector<EverydayCommand> EverydayCommands() {
  std::vector<EverydayCommand> commands;
  for (const auto& [title, name] : kEveryday) {
    if (const auto* subcommand = FindSubcommandNamed(name)) {
      commands.push_back({title, name, subcommand->arguments, subcommand->summary});
    } else if (const auto* family = FindCommandFamily(name)) {
      commands.push_back({title, name, "...", family->summary});
    } else if (const auto type = vda5050::ActionCalled(name)) {
      const auto* action = vda5050::FindAction(vda5050::kVersions.back(), *type);
      commands.push_back({title, name, "TARGET...", action->summary});
    }
  }
  return commands;
}

}  // namespace fleetpub::cli
