// The table of subcommands. Predefined actions are not in it: they come from the catalogue.
#include <array>

#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using enum HelpGroup;

constexpr auto kSubcommands = std::to_array<Subcommand>({
    {"action", kRobots, "TYPE TARGET...", "send any instant action, such as a manufacturer's own",
     "action beep KIT/0001 -P duration:=3 -P mode=loud\n"
     "action beep 'KIT/*' --except KIT/0001 --where 'battery>20' --yes\n"
     "action customScan KIT/0001 KIT/0002 -P area:=@area.json --wait",
     DeclareAction},
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
     "fleet 'KIT/*' @hall-1 -o json",
     DeclareFleet},
    {"watch", kLooking, "[TARGET...]", "the same, live", "watch\nwatch 'KIT/*' --for 1m -o json",
     DeclareWatch},
    {"await", kLooking, "TARGET [TOPIC] CONDITION...", "wait until robots' messages say so",
     "await KIT/0001 paused=true\n"
     "await KIT/0001 'battery>=80' charging=false -W 2h\n"
     "await KIT/0001 connection connectionState=ONLINE\n"
     "await 'KIT/*' paused=true",
     DeclareAwait},
    {"actions", kLooking, "", "the catalogue of predefined actions, with their parameters",
     "actions\n"
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
    {"schema list", kChecking, "", "the schemas that there are", "schema list", DeclareSchemaList},
    {"schema show", kChecking, "NAME", "print a schema",
     "schema show vda5050/3.0.0/instantActions\n"
     "schema show output/result",
     DeclareSchemaShow},
    {"simulate", kChecking, "TARGET...", "virtual robots that answer, with faults on demand",
     "simulate KIT/0001\n"
     "simulate KIT/0001 --count 100 --vda 2.1 --state-interval 5s\n"
     "simulate KIT/0001 --delay 3s --fail startCharging --reject pause\n"
     "simulate --protocol soar soar.planet-ocean.ecosub.eco1 --delay 3s",
     DeclareSimulate},
    {"config show", kChecking, "", "the settings in force, and where each comes from",
     "config show\n"
     "config show --profile north -o json",
     DeclareConfigShow},
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
    {"ping", kChecking, "", "can the broker be reached with these settings, and what does it grant",
     "ping\n"
     "ping --wait 20s\n"
     "ping -b mqtt://broker.example:1883 -u operator --password-file pw",
     DeclarePing},
});

}  // namespace

std::span<const Subcommand> Subcommands() { return kSubcommands; }

}  // namespace fleetpub::cli
