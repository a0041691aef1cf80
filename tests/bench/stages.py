"""Adds up by stage what callgrind counted in one run of fleetpub: instructions, and the time in system calls.

  stages.py CALLGRIND RUN ROBOTS CSV

CALLGRIND was written with --collect-systime=nsec. Prints a table and appends it to CSV. A stage's cost is that of its functions
with everything that they call, without the stages within it. Functions that the optimiser has built into their callers are not
seen: the table names virtual functions and those of other files, which it leaves alone. Fails when more than a tenth of the
instructions belongs to no stage, for then the table has to be mended.
"""

import csv
import os
import re
import subprocess
import sys

# stage → its functions (of `A|B` the first that is there), and a stage that is within it. What else is below main is `rest`; what is not, `start`.
STAGES = {
    "start": ([], None),
    "arguments": (["cli::CommandLine::Read", "cli::CommandLine::Configure", "app::ResolveTargets", "app::MakeDirectory"], None),
    "build": (["app::CommandFactory::Validate", "CommandSender::Next|app::CommandFactory::Build"], "validate"),
    "validate": (["delivery::Validate"], None),
    "open ledger": (["cli::OpenLedger"], None),
    "connect": (["mqtt::ConnectPaho"], None),
    "lock": (["ledger::SqliteLedger::Lock"], None),
    "reserve": (["delivery::BatchPublisher::Reserve|ledger::SqliteLedger::Reserve"], None),
    "publish": (["mqtt::PahoTransport::Admits", "mqtt::PahoTransport::AwaitReady", "mqtt::PahoTransport::Publish",
                 "mqtt::PahoTransport::Cork"], None),
    "answers": (["delivery::CommandSession::Subscribe|mqtt::PahoTransport::Subscribe", "delivery::CommandSession::ReadOne|mqtt::PahoTransport::Receive",
                 "mqtt::PahoTransport::AwaitAcknowledgements"], None),
    "outcome": (["ledger::SqliteLedger::RecordOutcomes"], None),
    "report": (["cli::Reporter::Show"], None),
    "close": (["mqtt::PahoTransport::Disconnect", "mqtt::PahoTransport::~PahoTransport",
               "ledger::SqliteLedger::~SqliteLedger"], None),
    "rest": ([], None),
}
MOST_WITHOUT_STAGE = 0.1
EVENTS = ("Ir", "sysCount", "sysTime")


def read(file):
    """The total, and {function: its cost with all that it calls}; a cost is (instructions, system calls, nanoseconds)."""
    text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--auto=no", "--threshold=100", f"--show={','.join(EVENTS)}", file],
                          check=True, capture_output=True, text=True, errors="replace").stdout
    line = re.compile(r"^\s*" + r"([\d,]+|\.)(?: *\([^)]*%\))?\s+" * len(EVENTS) + r"(\S.*)$", re.MULTILINE)
    total, costs = None, {}
    for *numbers, name in line.findall(text):
        cost = tuple(0 if number == "." else int(number.replace(",", "")) for number in numbers)
        if name == "PROGRAM TOTALS":
            total = cost
            continue
        name = name.split(":", 1)[1].replace("(anonymous namespace)::", "").removeprefix("fleetpub::")
        name = re.split(r"[(\[ ]", name)[0]
        costs[name] = max(cost, costs.get(name, cost))
    return total, costs


def plus(a, b, sign=1):
    return tuple(x + sign * y for x, y in zip(a, b))


def by_stage(total, costs):
    nothing = (0,) * len(EVENTS)
    stages = {}
    for stage, (functions, _) in STAGES.items():
        stages[stage] = nothing
        for names in functions:
            cost = next((costs[name] for name in names.split("|") if name in costs), nothing)
            stages[stage] = plus(stages[stage], cost)
    for stage, (_, within) in STAGES.items():
        if within:
            stages[stage] = plus(stages[stage], stages[within], -1)
    stages["start"] = plus(total, costs["main"], -1)
    stages["rest"] = total
    for stage, cost in list(stages.items())[:-1]:
        stages["rest"] = plus(stages["rest"], cost, -1)
    return stages


def main():
    callgrind, run, robots, table = sys.argv[1:]
    total, costs = read(callgrind)
    stages = by_stage(total, costs)
    print(f"{run:<44} {'instructions':>14} {'%':>6} {'system calls':>13} {'milliseconds':>13}")
    for stage, (instructions, calls, nanoseconds) in stages.items():
        print(f"  {stage:<42} {instructions:>14,} {100 * instructions / total[0]:>6.1f} {calls:>13,} {nanoseconds / 1e6:>13.3f}")
    is_new = not os.path.exists(table)
    with open(table, "a", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        if is_new:
            rows.writerow(["run", "robots", "stage", "instructions", "system_calls", "system_nanoseconds"])
        rows.writerows([run, robots, stage, *cost] for stage, cost in stages.items())
    if stages["rest"][0] > MOST_WITHOUT_STAGE * total[0] or min(min(cost) for cost in stages.values()) < 0:
        sys.exit(f"stages.py: the stages of '{run}' do not fit the program any more")


main()
