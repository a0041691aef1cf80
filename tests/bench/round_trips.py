"""Tells from a strace of one command how often PostgreSQL was waited for, and for what.

  round_trips.py STRACE PORT CSV

A round trip is what was sent to the database until something was received from it. `strace -yy` names the port. What was sent
to the broker in between is counted: messages that left.
"""

import csv
import itertools
import re
import sys

# What a round trip is about: the first of these that stands in what was sent. The order matters.
ABOUT = [
    ("pg_try_advisory_lock", "lock the topics, read their last ids"),
    ("WITH taken", "reserve the ids, record the messages"),
    ("UPDATE fleetpub.messages", "record the outcomes"),
    ("set_config", "settings of the session"),
    ("application_name", "log in"),
    ("", "ask for TLS"),
]


def events(lines, port):
    """('sent' | 'received' | 'published', bytes, text), in order."""
    call = re.compile(r"(sendto|recvfrom|writev)\(\d+<TCP:\[[^]]*:(\d+)\]>, (.*)= (\d+)$")
    for line in lines:
        found = call.search(line)
        if not found:
            continue
        name, peer, text, count = found.groups()
        if peer == port:
            yield "sent" if name == "sendto" else "received", int(count), text
        elif name == "writev" and "/instantActions" in text:
            yield "published", int(count), ""


def main():
    strace, port, table = sys.argv[1:]
    steps = []  # [what, round trips or messages, bytes]
    with open(strace) as lines:
        for kind, group in itertools.groupby(events(lines, port), key=lambda event: event[0]):
            group = list(group)
            size = sum(event[1] for event in group)
            if kind == "published":
                steps.append([f"{len(group)} messages to the broker", 0, size])
            elif kind == "sent":
                text = "".join(event[2] for event in group)
                steps.append([next(about for word, about in ABOUT if word in text), 0, size])
            elif steps:
                steps[-1][1] += 1
    if steps and steps[-1][1:] == [0, 5]:
        steps.pop()  # the farewell, which nobody answers
    print(f"{'':<44} {'round trips':>11} {'bytes sent':>11}")
    for what, trips, size in steps:
        print(f"{what:<44} {trips:>11} {size:>11}")
    with open(table, "w", newline="") as file:
        csv.writer(file).writerows([["step", "round_trips", "bytes_sent"], *steps])


main()
