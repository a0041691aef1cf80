"""Holds what the program said and recorded against what a subscriber saw."""

import collections
import shutil
import signal
import sqlite3

FLAWS = ("repeated ids", "ids backwards", "seen, no row", "untrue", "hangs", "crashes")

# Exit codes after which the manual says that nothing was sent.
NOTHING_SENT = {2, 3, 7, 8}
KNOWN = {0, 1, 2, 3, 4, 5, 6, 7, 8, 130, 143}
SENT = {"SENT", "PUBLISHED", "ACCEPTED", "FINISHED", "FAILED", "REJECTED", "RETRIABLE", "VANISHED", "OFFLINE", "TIMEOUT"}
UNSURE = ("perhaps sent", "sent, but not acknowledged", "may or may not", "the broker did not acknowledge it")


class Tally:
    """What one kind of torture came to."""

    def __init__(self, name):
        self.name = name
        self.rounds = 0
        self.seen = 0
        self.ends = collections.Counter()
        self.flaws = collections.Counter()
        self.complaints = []

    def report(self, flaw, what):
        self.flaws[flaw] += 1
        self.complaints.append(f"{self.name}: {flaw}: {what}")


class Ledger:
    """A ledger's folder, and what was seen of the messages that it counted."""

    def __init__(self, folder, seen=()):
        self.folder = folder
        self.seen = list(seen)  # (topic, headerId, actionId, payload), as they arrived

    def copy(self, folder):
        shutil.copytree(self.folder, folder, dirs_exist_ok=True)
        return Ledger(folder, self.seen)

    def rows(self, scratch):
        """(topic, headerId) → (payload, status), the newest first as far as the file can be read. From a copy: to open a
        database is to change it."""
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir()
        for end in ("", "-wal"):
            if (self.folder / f"ledger.db{end}").exists():
                shutil.copy(self.folder / f"ledger.db{end}", scratch)
        database = sqlite3.connect(scratch / "ledger.db")
        database.text_factory = lambda text: text.decode(errors="replace")
        rows = {}
        try:
            for topic, header_id, *row in database.execute(
                    "SELECT topic, header_id, payload, status FROM messages ORDER BY id DESC"):
                rows.setdefault((topic, header_id), tuple(row))
        except sqlite3.DatabaseError:
            pass  # no ledger yet, or damaged further down
        finally:
            database.close()
        return rows


def end_of(run):
    if run.hung:
        return "hung"
    if run.killed:
        return "killed"
    return f"exit {run.code}" if run.code >= 0 else signal.Signals(-run.code).name


def check_claims(run, seen, tally, what):
    """The exit code and each result line, against what arrived of this call."""
    said = " ".join([run.err.strip()[-300:], *(result.get("message", "") for result in run.results)]).strip()
    what = f"{what}: {end_of(run)}: {said}"
    topics = {topic for topic, _, _, _ in seen}

    def is_unsure(result):
        return any(words in result.get("message", "") for words in UNSURE)

    lost = [r for r in run.results if r.get("topic") not in topics and is_unsure(r)]
    if run.hung:
        tally.report("hangs", what)
        return
    if not run.killed:
        if run.code < 0:
            tally.report("crashes", what)
        # 127: the dynamic loader could not even start the program.
        elif run.code not in KNOWN and not (run.code == 127 and not seen):
            tally.report("untrue", what)
        elif run.code in NOTHING_SENT and seen and not any(r.get("status") in SENT for r in run.results):
            tally.report("untrue", f"{what}: but it arrived")
        elif run.code in (0, 5, 6) and len(seen) + len(lost) < len(run.targets):
            tally.report("untrue", f"{what}: but {len(seen)} of {len(run.targets)} arrived")
        elif "nothing was sent" in run.err and seen:
            tally.report("untrue", f"{what}: but it arrived")
    for result in run.results:
        status, message = result.get("status"), result.get("message", "")
        arrived = result.get("topic") in topics
        if status in SENT and not arrived and not (status == "TIMEOUT" and is_unsure(result)):
            tally.report("untrue", f"{what}: {status}, but it did not arrive")
        if status == "ERROR" and arrived and not is_unsure(result):
            tally.report("untrue", f"{what}: {message}, but it arrived")


def check_ids(ledger, seen, tally, what, in_order=True):
    """Ids against all that were ever seen of this ledger."""
    known = collections.defaultdict(list)
    for topic, header_id, _, _ in ledger.seen:
        known[topic].append(header_id)
    for message in seen:
        topic, header_id = message[0], message[1]
        if header_id in known[topic]:
            tally.report("repeated ids", f"{what}: {header_id} on {topic}")
        elif in_order and known[topic] and header_id < max(known[topic]):
            tally.report("ids backwards", f"{what}: {header_id} after {max(known[topic])} on {topic}")
        known[topic].append(header_id)
    ledger.seen += seen


def check_rows(ledger, scratch, tally, what, since=0):
    """Each message that was seen has its row, with its very payload. `since`: of the newest ones only."""
    rows = ledger.rows(scratch)
    for topic, header_id, _, payload in ledger.seen[since:]:
        row = rows.get((topic, header_id))
        if row is None or row[0] != payload:
            tally.report("seen, no row", f"{what}: {header_id} on {topic}")
