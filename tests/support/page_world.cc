#include "support/page_world.h"

namespace fleetpub::testing {
namespace {

constexpr const char* kPrelude = R"sh(
trap 'kill $(jobs -p) 2>/dev/null; kill -CONT $(jobs -p) 2>/dev/null; wait' EXIT
shopt -s expand_aliases
background() { local log; log=$(mktemp -p .); "$@" >"$log" 2>&1 & until grep -q online "$log"; do sleep .02; done; cat "$log"; }
until_killed() { background "$@"; kill $!; wait $!; }
online() { background fleetpub simulate --state-interval 50ms "$@" >/dev/null; }
gone() { place=vda5050/v3; version=3.0.0; if [ "${2:-}" = --vda ]; then place=uagv/v2; version=2.1.0; fi
  publish -r -q 1 -t "$place/$1/connection" -m '{"headerId":1,"timestamp":"'"$(date -u +%FT%TZ)"'","version":"'$version'",
  "manufacturer":"'"${1%/*}"'","serialNumber":"'"${1#*/}"'","connectionState":"OFFLINE"}'; }
everybody_goes() { kill $(jobs -p); wait; }
order() { echo '{"orderId":"o-1","orderUpdateId":0,"nodes":[{"nodeId":"n1","sequenceId":0,"released":true,"actions":[],
  "nodePosition":{"x":-5,"y":5,"mapId":"map-1"}},{"nodeId":"n2","sequenceId":2,"released":true,"actions":[],
  "nodePosition":{"x":5,"y":5,"mapId":"map-1"}}],"edges":[{"edgeId":"e1","sequenceId":1,"released":true,
  "startNodeId":"n1","endNodeId":"n2","actions":[]}]}'; }
zones() { echo '{"zoneSet":{"mapId":"map-1","zoneSetId":"hall-1","zones":[{"zoneId":"gate","zoneType":"RELEASE",
  "releaseLossBehavior":"STOP","vertices":[{"x":0,"y":0},{"x":10,"y":0},{"x":10,"y":10},{"x":0,"y":10}]}]}}'; }
publish() { mosquitto_pub -p "$PORT" "$@"; }
# place ID X Y [ACTIONS], way FROM TO, hall PLACES WAYS: a layout of one hall, whose station dock-3 is at n17.
place() { printf '{"nodeId":"%s","mapId":"map-1","nodePosition":{"x":%s,"y":%s},"vehicleTypeNodeProperties":[{
  "vehicleTypeId":"T","actions":[%s]}]}' "$1" "$2" "$3" "${4:-}"; }
way() { printf '{"edgeId":"%s-%s","startNodeId":"%s","endNodeId":"%s","vehicleTypeEdgeProperties":[{"vehicleTypeId":"T",
  "rotationAllowed":true}]}' "$1" "$2" "$1" "$2"; }
needs() { printf '{"actionType":"%s","requirementType":"REQUIRED","blockingType":"HARD"}' "$1"; }
hall() { printf '{"metaInformation":{"projectIdentification":"p","creator":"c","exportTimestamp":"2026-01-01T00:00:00Z",
  "lifVersion":"1.0.0"},"layouts":[{"layoutId":"hall","layoutVersion":"1","nodes":[%s],"edges":[%s],"stations":[{
  "stationId":"dock-3","interactionNodeIds":["n17"]}]}]}' "$1" "$2"; }
# listens PORT LINE...: a second broker, with these lines of configuration; $broker is its process.
listens() {
  { echo "listener $1 127.0.0.1"; [ "$(id -u)" -ne 0 ] || echo "user root"; printf '%s\n' "${@:2}"; } >"$1.conf"
  mosquitto -c "$1.conf" >"$1.log" 2>&1 & broker=$!
  until grep -q running "$1.log"; do sleep .02; done
}
# certify NAME: plant-ca.pem, an authority, and broker.pem and broker.key, signed by it for NAME.
certify() {
  local key="-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes"
  { openssl req -x509 $key -days 2 -subj /CN=plant -keyout ca.key -out plant-ca.pem
    openssl req $key -subj /CN=broker -keyout broker.key -out broker.csr
    openssl x509 -req -in broker.csr -CA plant-ca.pem -CAkey ca.key -CAcreateserial -days 2 \
      -extfile <(echo "subjectAltName=DNS:$1") -out broker.pem; } 2>/dev/null
}
# at_a_command PORT COMMAND: runs it as soon as that broker has carried a command to a robot.
at_a_command() {
  local log; log=$(mktemp -p .)
  { stdbuf -oL mosquitto_sub -d -C 1 -p "$1" -t '+/+/+/+/instantActions' >"$log"; ${@:2}; } &
  until grep -q Subscribed "$log"; do sleep .02; done
}
)sh";

const World kTargets = {
    .setup =
        "online KIT/0001 --count 2; printf 'KIT/0001,hall 1\\nKIT/0002,hall 2\\n' > robots.csv",
    .before = {{"fleetpub pause --all --wait --timeout 3s",
                "everybody_goes; gone KIT/0005; online KIT/0001; online KIT/0002 --delay 2s\n"
                "online KIT/0003 --fail startPause; online KIT/0004 --silent"}},
    .codes = {{"fleetpub charge --all --where 'battery<20'", 7},  // none is that low
              {"fleetpub pause --all --wait --timeout 3s", 5}}};

const World kOrders = {
    .setup =
        "online KIT/0001 --count 2 --order-time 1s; order > order.json; zones > hall-1.json\n"
        "fleetpub publish zoneSet KIT/0001 -f hall-1.json --wait\n"
        "fleetpub enableZoneSet KIT/0001 --zoneSetId hall-1 --wait\n"
        "echo '{\"actions\":[{\"actionType\":\"stateRequest\",\"actionId\":\"a1\","
        "\"blockingType\":\"NONE\"}]}' > actions.json"};

const World kDriving = {
    .setup =
        "hall \"$(place n1 0 0),$(place n2 1 0),$(place n4 1 1),$(place n7 2 0),$(place n8 3 0),"
        "$(place n9 3 1),$(place n17 2 1)\" \"$(way n1 n2),$(way n2 n7),$(way n7 n8),$(way n8 n9),"
        "$(way n7 n4),$(way n4 n17),$(way n17 n1),$(way n17 n7),$(way n9 n1)\" > hall.lif.json\n"
        "mkdir -p ~/.config/fleetpub\n"
        "echo \"layout = \\\"$PWD/hall.lif.json\\\"\" > ~/.config/fleetpub/config.toml\n"
        "online KIT/0001 --at n1 --layout hall.lif.json --time-scale 40",
    .before = {{"fleetpub order KIT/0001 --to dock-3 --wait", "fleetpub order follow KIT/0001"},
               {"fleetpub order KIT/0001 --to dock-3 --via n4 --action pick@dock-3 loadType=EPAL "
                "--release 3",
                "fleetpub order KIT/0001 --to n1 --wait"},
               {"fleetpub order extend KIT/0001 n8 n9",
                "fleetpub order release KIT/0001 --wait; fleetpub order KIT/0001 n17 n7 --wait"},
               {"fleetpub order release KIT/0001 2",
                "fleetpub order follow KIT/0001; fleetpub order KIT/0001 n9 n1 n2 n7 --release 1 "
                "--wait-for accepted"},
               {"fleetpub order follow KIT/0001", "fleetpub order KIT/0001 n1 n2"}}};
const World kLayouts = {
    .setup =
        "hall \"$(place n1 0 0),$(place n4 10 0),$(place n17 10 13.4 \"$(needs pick),$(needs "
        "beep)\")\" \"$(way n1 n4),$(way n4 n17),$(way n17 n1)\" > hall.lif.json\n"
        "mkdir -p ~/.config/fleetpub\n"
        "printf 'layout = \"%s\"\\n[profile.north]\\nlayout = \"%s\"\\n' \"$PWD/hall.lif.json\" "
        "\"$PWD/hall.lif.json\" > ~/.config/fleetpub/config.toml"};

const World kLooking = {
    .setup =
        "online KIT/0001; gone KIT/0002 --vda 2.1; fleetpub pause KIT/0001 --wait\n"
        "fleetpub charge KIT/0001 --wait",
    // The one that has gone would be waited for.
    .before = {
        {"fleetpub await KIT/0001 paused=true",
         "fleetpub uncharge KIT/0001 --wait; publish -r -n -t uagv/v2/KIT/0002/connection"}}};

const World kShow = {.setup =
                         "online KIT/0001 --battery 15 --error 'motorFault:FATAL:motor 2 is hot' "
                         "--emergency-stop --position 1.5,-2,0.5,hall-1 --at n5 --with-order\n"
                         "fleetpub pause KIT/0001 --wait"};

const World kRecordings = {.setup = "online KIT/0001 --with-order",
                           .changes = {{"--for 8h", "--for 500ms"}}};

const World kSoar = {
    .setup =
        "background fleetpub simulate --protocol soar soar.planet-ocean.ecosub.eco1\n"
        "printf 'lat,lon,depth\\n50.37,-4.19,15\\n50.36,-4.20,15\\n' > waypoints.csv\n"
        "echo '{\"planning_config_ID\":3,\"squads\":[],\"exclusion_zones\":[]}' > squads.json\n",
    .changes = {{" ID ", " 00000000-0000-4000-8000-000000000000 "}}};

const World kLive = {
    .setup =
        "online KIT/0001; online KIT/0002\n"
        "publish -r -t vda5050/v3/KIT/0002/connection -m '{\"headerId\":3,\"timestamp\":"
        "\"2026-01-02T03:04:05.000Z\",\"version\":\"3.0.0\",\"manufacturer\":\"KIT\","
        "\"serialNumber\":\"0001\",\"connectionState\":\"ONLINE\"}'\n"
        "state=$(mosquitto_sub -p $PORT -C 1 -t vda5050/v3/KIT/0001/state)\n"
        "state=$(sed 's/\"charging\":[a-z]*/\"charging\":\"yes\"/; "
        "s/\"headerId\":[0-9]*/\"headerId\":17/' <<<\"$state\")\n"
        "{ sleep 1; publish -t vda5050/v3/KIT/0001/state -m \"$state\"; } &",
    .codes = {{"fleetpub validate --live", 3}},
    .changes = {{"--for 60s", "--for 3s"}}};

const std::map<std::string, World>& Troubles() {
  static const std::string kTls =
      "listens $PORT_8883 'allow_anonymous true' 'certfile broker.pem' 'keyfile broker.key'";
  // KIT/0001 may do all, everybody else may read.
  static const std::string kReader =
      "printf 'topic read #\nuser robot\ntopic #\n' > acl; echo secret > password; chmod 600 "
      "password\n"
      "mosquitto_passwd -b -c passwords robot secret\n"
      "listens $PORT_1884 'allow_anonymous true' 'acl_file acl' 'password_file passwords'\n"
      "online KIT/0001 -b mqtt://localhost:$PORT_1884 -u robot --password-file password";
  static const std::string kNorth =
      "mkdir -p ~/.config/fleetpub; printf '[profile.north]\nbroker = \"mqtt://north.example\"\n' "
      "> ~/.config/fleetpub/config.toml";
  static const std::map<std::string, World> troubles = {
      {"Something listens and says nothing (exit 4)",
       {.setup = "listens $PORT_1884 'allow_anonymous true'; kill -STOP $broker"}},
      {"The port speaks TLS, or does not (exit 4)", {.setup = "certify localhost; " + kTls}},
      {"The login is refused (exit 4)",
       {.setup = "mosquitto_passwd -b -c passwords operator right\n"
                 "listens $PORT_1884 'allow_anonymous false' 'password_file passwords'\n"
                 "echo wrong > password; chmod 600 password"}},
      {"The certificate is not trusted (exit 4)", {.setup = "certify localhost; " + kTls}},
      {"The certificate is for another name (exit 4)",
       {.setup = "certify broker.example; " + kTls}},
      {"The broker asks for a client certificate (exit 4)",
       {.setup =
            "certify localhost; " + kTls + " 'cafile plant-ca.pem' 'require_certificate true'"}},
      {"The broker refuses the message (exit 4)", {.setup = kReader}},
      {"Published, but no robot moves (exit 0)", {.setup = kReader}},
      {"The connection is lost while waiting (exit 6)",
       {.setup = "listens $PORT_1884 'allow_anonymous true'\n"
                 "online KIT/0001 -b mqtt://localhost:$PORT_1884 --silent\n"
                 "disown $broker; trap 'kill $broker $(jobs -p) 2>/dev/null; wait' EXIT\n"
                 "at_a_command $PORT_1884 kill -9 $broker"}},
      {"The robot is unknown (exit 7)", {.setup = "online KIT/0001"}},
      {"A pause for a robot that is unknown (exit 0)", {.setup = "online KIT/0001"}},
      {"The broker keeps no retained messages (exit 7)",
       {.setup = "listens $PORT_1884 'allow_anonymous true' 'retain_available false'"}},
      {"The robot is offline (exit 7)", {.setup = "gone KIT/0002"}},
      {"A pause for a robot that looks offline (exit 6)", {.setup = "gone KIT/0002"}},
      {"The robot speaks another version (exit 7)", {.setup = "online KIT/0001 --vda 2.1"}},
      {"The robot is under another interface (exit 7)",
       {.setup = "online KIT/0001 --interface hall"}},
      {"The robot does not have the action (exit 7)", {.setup = "online KIT/0001"}},
      {"A pattern matches nobody (exit 7)", {.setup = "online KIT/0001"}},
      {"No robot satisfies `--where` (exit 7)", {.setup = "online KIT/0001"}},
      {"`--where` cannot be decided (exit 7)", {.setup = "online KIT/0001 --silent"}},
      {"`--except` matches nobody (exit 7)", {.setup = "online KIT/0001"}},
      {"Several robots need consent (exit 2)", {.setup = "online KIT/0001 --count 2"}},
      {"The robot rejects the action (exit 5)",
       {.setup = "online KIT/0001 --vda 2.1 --reject startPause"}},
      {"The action failed (exit 5)", {.setup = "online KIT/0001 --fail startCharging"}},
      {"There was no order to cancel (exit 5)", {.setup = "online KIT/0001"}},
      {"The robot is in manual mode (exit 5)", {.setup = "online KIT/0001 --mode MANUAL"}},
      {"The robot is silent (exit 6)", {.setup = "online KIT/0001 --silent"}},
      {"The robot is not done in time (exit 6)", {.setup = "online KIT/0001 --delay 1min"}},
      {"The action can be tried again (exit 6)",
       {.setup = "online KIT/0001 --retriable startCharging"}},
      {"The robot goes offline while waiting (exit 6)",
       {.setup = "online KIT/0001 --delay 1min; at_a_command $PORT kill $!"}},
      {"A condition does not come true (exit 6)", {.setup = "online KIT/0001"}},
      {"A prepared message breaks its schema (exit 3)",
       {.setup = "order | sed 's/\"sequenceId\":0/\"sequenceId\":\"0\"/' > wrong.json\n"
                 "echo '{\"orderId\":\"o-1\",}' > cut.json"}},
      {"A prepared message is for another robot (exit 3)",
       {.setup = "order | sed 's/{/{\"manufacturer\":\"ACME\",/' > order.json"}},
      {"A header id is too low (exit 2)", {.setup = "online KIT/0001; fleetpub pause KIT/0001"}},
      {"A line of a batch is wrong (exit 3)",
       {.setup =
            "online KIT/0001; printf '%s\n' '{\"target\":\"KIT/0001\",\"acton\":\"startPause\"}' "
            "'{\"target\"' '{\"target\":\"KIT/0001\",\"action\":\"startPause\"}' "
            "> commands.jsonl"}},
      {"PostgreSQL cannot be reached (exit 8)", {.setup = "online KIT/0001"}},
      {"The disk is full (exit 8)", {.setup = "online KIT/0001"}},
      {"The results cannot be written (exit 0)", {.setup = "online KIT/0001"}},
      {"A schema folder has no schemas (exit 2)", {.setup = "mkdir empty"}},
      {"A broken schema of your own (exit 3)",
       {.setup = "mkdir schemas; echo '{\"type\":\"object\",}' > schemas/order.schema\n"
                 "order > message.json"}},
      {"An unknown key (exit 2)",
       {.setup = kNorth + "; sed -i 1i'borker = \"\"' ~/.config/fleetpub/config.toml"}},
      {"An unknown profile (exit 2)", {.setup = kNorth}},
      {"The profile and the environment disagree (exit 2)", {.setup = kNorth}},
      {"The configuration is refused (exit 2)",
       {.setup = kNorth + "; chmod o+w ~/.config/fleetpub/config.toml"}},
      {"A program prints no password (exit 8)",
       {.setup = "mkdir -p ~/.config/fleetpub; printf '\\n\\npassword_command = "
                 "[\"token-tool\"]\\n' > ~/.config/fleetpub/config.toml"}},
      {"A setting has no effect (exit 0)",
       {.setup = kNorth + "; echo 'qos = 0' >> ~/.config/fleetpub/config.toml\n"
                          "export FLEETPUB_QOS=1; unset FLEETPUB_BROKER"}},
      {"The ledger is locked (exit 8)",
       {.setup = "online KIT/0001; fleetpub ledger migrate; mkfifo lock; sqlite3 $FLEETPUB_LEDGER "
                 "< lock > locked &\n"
                 "exec 7> lock; echo 'begin immediate; select 1;' >&7\n"
                 "until grep -q 1 locked; do sleep .02; done"}},
      {"The ledger is damaged (exit 8)", {.setup = "online KIT/0001; echo nonsense > broken.db"}},
      {"The ledger belongs to another program (exit 8)",
       {.setup = "online KIT/0001; sqlite3 other.db 'CREATE TABLE accounts (name)'"}},
      {"The ledger is a link in a shared folder (exit 8)",
       {.setup = "online KIT/0001; fleetpub ledger migrate; mkdir shared; chmod 770 shared\n"
                 "ln -s $FLEETPUB_LEDGER shared/ledger.db"}}};
  return troubles;
}

}  // namespace

const char* WorldFunctions() { return kPrelude; }

const std::map<std::string, std::map<std::string, World>>& Worlds() {
  static const std::map<std::string, std::map<std::string, World>> worlds = {
      {"docs/manual.md",
       {
           {"Commands",
            {.setup = "online KIT/0001",
             .codes = {{"fleetpub action beep", 7}}}},  // virtual robots do not beep
           {"Targets", kTargets},
           {"Output", {.setup = "online KIT/0001"}},
           {"Files", {.setup = "online KIT/0001"}},
           {"Waiting", {.setup = "online KIT/0001"}},
           {"Completion",
            {.setup =
                 "mkdir -p ~/.local/share/bash-completion/completions ~/.config/fish/completions\n"
                 "fpath=(\"\" \"$HOME\")"}},
           {"Orders", kDriving},
           {"Orders and other messages", kOrders},
           {"Layouts", kLayouts},
           {"Batch",
            {.setup =
                 "online KIT/0001\n"
                 "echo '{\"target\":\"KIT/0001\",\"action\":\"startPause\"}' > commands.jsonl"}},
           {"Fleet, watch, await", kLooking},
           {"Show", kShow},
           {"Recordings", kRecordings},
           {"Conformance", {.setup = "online KIT/0001"}},
           {"Report files",
            {.setup = "mkdir orders\n"
                      "echo '{\"orderId\":\"o\",\"orderUpdateId\":0,\"edges\":[],\"nodes\":[{"
                      "\"nodeId\":\"n\",\"sequenceId\":0,\"released\":true,\"actions\":[]}]}' "
                      "> orders/south.json"}},
           {"Scenarios",
            {.setup = "printf '[[test]]\nname = \"a pause\"\nsteps = [{ simulate = \"KIT/0001\" }, "
                      "{ send = \"pause KIT/0001 --wait\" }]\n' > smoke.toml"}},
           {"Doctor", {.setup = "online KIT/0001"}},
           {"SoAR", kSoar},
           {"Validation",
            {.setup = "mkdir orders\n"
                      "printf '{\"orderId\":\"o\",\"orderUpdateId\":0,\"edges\":[],\\n  "
                      "\"nodes\":[{\"nodeId\":\"n\",\"sequenceId\":0,\\n    "
                      "\"released\":true,\"actions\":[]}]}' > orders/south.json\n"
                      "sed 's/true/\"true\"/' orders/south.json > orders/north.json",
             .codes = {{"fleetpub validate orders/", 3}}}},
           {"Live", kLive},
       }},
      {"README.md",
       {{"Five recipes",
         {.setup =
              "online KIT/0001; background fleetpub simulate --protocol soar soar.noc.autosub.ah1\n"
              "echo '{\"type\":\"LineString\",\"coordinates\":[[-4.18,50.37],[-4.19,50.37]]}' "
              "> route.geojson"}}}},
      {"docs/scale.md",
       {{"A hundred thousand robots: by site",
         {.setup =
              "mkdir -p ~/.config/fleetpub; printf '[profile.%s]\\nqos = 0\\n' north south west > "
              "~/.config/fleetpub/config.toml\n"
              "online KIT/0001 --for 20s; disown -a"}}}},
      {"docs/troubleshooting.md", Troubles()}};
  return worlds;
}

}  // namespace fleetpub::testing
