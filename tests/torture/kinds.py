"""The ways in which the program is hurt. Each kind does its rounds and returns a Tally."""

import contextlib
import fcntl
import os
import random
import resource
import shutil
import signal
import sqlite3
import struct
import subprocess
import threading
import time

from checks import Ledger, Tally, end_of, check_claims, check_ids, check_rows
from world import system_calls, wait_until

NOBODY = 65534
THREE = ("KIT/0001", "KIT/0002", "KIT/0003")


def check(world, ledger, run, tally, what, seen=None):
    """`seen`: what arrived of this call; else it is the only one, and everything that arrives is its."""
    seen = world.witness.drain() if seen is None else seen
    since = len(ledger.seen)
    tally.rounds += 1
    tally.seen += len(seen)
    tally.ends[end_of(run)] += 1
    check_claims(run, seen, tally, what)
    check_ids(ledger, seen, tally, what)
    if seen and "--no-history" not in run.options:
        check_rows(ledger, world.folder / "rows", tally, what, since)


def side_by_side(world, trials, tally, at_once=8):
    """Trials, each (ledger of its own, what it is, options of World.call…); many of them only wait. The call that comes
    next on each ledger must succeed."""
    def work():
        while queue:
            with contextlib.suppress(IndexError):
                ledger, what, arguments, options = queue.pop()
                done.append((ledger, what, world.call(ledger.folder, *arguments, **options)))

    for begin in range(0, len(trials), 64):
        queue, done = list(reversed(trials[begin:begin + 64])), []
        for what_now in ("", ", the call after it"):
            workers = [threading.Thread(target=work) for _ in range(at_once)]
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.join()
            seen = world.witness.drain()
            for ledger, what, run in done:
                check(world, ledger, run, tally, what, [m for m in seen if f'"{run.action_id}"' in m[3]])
                if what_now and run.code != 0:
                    tally.report("untrue", f"{what}: ended with {run.code}: {run.err} {run.results}")
            queue, done = [(ledger, what + ", the call after it", (), {}) for ledger, what, _ in done if not what_now], []
        for ledger, *_ in trials[begin:begin + 64]:
            shutil.rmtree(ledger.folder)


def new_ledger(world, name, calls=0):
    ledger = Ledger(world.new_folder(name))
    for _ in range(calls):
        run = world.call(ledger.folder)
        if run.code != 0:
            raise RuntimeError(f"{name}: {run.err}")
    ledger.seen += world.witness.drain()
    return ledger


# --- kill -9 ---------------------------------------------------------------------------------------------------------

VARIANTS = (
    ("QoS 0", (), ("KIT/0001",)),
    ("QoS 1", ("-q", "1"), ("KIT/0001",)),
    ("QoS 1, three robots", ("-q", "1"), THREE),
    ("--wait", ("--wait", "-W", "5s"), ("KIT/0001",)),
    ("no history", ("--no-history",), ("KIT/0001",)),
)


def kill_at_random(world, rounds):
    """At any moment of the call: one after the other on one ledger, which is remade at times."""
    tally = Tally("`kill -9` at a random moment")
    ledger, known = None, {}
    for turn in range(rounds):
        if turn % 100 == 0:
            ledger = new_ledger(world, "random")
        name, options, targets = VARIANTS[turn % len(VARIANTS)]
        if name not in known:
            start = time.monotonic()
            world.call(ledger.folder, options, targets)
            known[name] = time.monotonic() - start
            ledger.seen += world.witness.drain()
        run = world.call(ledger.folder, options, targets, kill_after=random.uniform(0, 1.2 * known[name]))
        check(world, ledger, run, tally, name)
    return tally


def sample(items, most):
    """At most so many of them, in their order; None: all."""
    if most is None or len(items) <= most:
        return items
    return [items[i] for i in sorted(random.sample(range(len(items)), most))]


def kill_at_each_call(world, most=None):
    """Before each single system call of a call: after reserving, recording, writing, while waiting."""
    tally = Tally("`kill -9` at each system call")
    points = []
    for name, options, targets in VARIANTS[:4]:
        for fresh in (True, False):
            counts = system_calls(world, new_ledger(world, "count", 0 if fresh else 2).folder, options)
            world.witness.drain()
            points += [(name, options, targets, fresh, call, n + 1)
                       for call, (_, count) in counts.items() if call not in ("execve", "exit_group") for n in range(count)]
    trials = []
    old = new_ledger(world, "old", 2)
    for name, options, targets, fresh, call, n in sample(points, most):
        ledger = new_ledger(world, "killed") if fresh else old.copy(world.new_folder("killed"))
        inject = ("strace", "-f", "-qq", "-o", "/dev/null", "-e", f"inject={call}:signal=SIGKILL:when={n}")
        what = f"{name}, {'new' if fresh else 'old'} ledger, {call} #{n}"
        trials.append((ledger, what, (options, targets), {"before": inject, "expect_kill": True}))
    side_by_side(world, trials, tally)
    return tally


def kill_in_parallel(world, rounds):
    """Four at a time on one ledger and the same topics, half of them killed."""
    tally = Tally("`kill -9` among four in parallel")
    ledger = new_ledger(world, "parallel")
    lock, runs = threading.Lock(), []

    def work(count):
        for _ in range(count):
            kill = random.uniform(0, 0.05) if random.random() < 0.5 else None
            targets = THREE if random.random() < 0.3 else ("KIT/0001",)
            run = world.call(ledger.folder, ("-q", "1"), targets, kill_after=kill)
            with lock:
                runs.append(run)

    workers = [threading.Thread(target=work, args=(rounds // 4,)) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    seen = world.witness.drain()
    tally.rounds, tally.seen = len(runs), len(seen)
    for run in runs:
        mine = [message for message in seen if f'"{run.action_id}"' in message[3]]
        tally.ends[end_of(run)] += 1
        check_claims(run, mine, tally, "in parallel")
    # A message that was acknowledged came before the next one on its topic. Of a killed process's last one the broker
    # may not have known when the next process had the topic.
    ended = {run.action_id for run in runs if run.code == 0}
    check_ids(ledger, seen, tally, "in parallel", in_order=False)
    check_ids(Ledger(None), [m for m in seen if any(f'"{i}"' in m[3] for i in ended)], tally, "of those that ended")
    check_rows(ledger, world.folder / "rows", tally, "in parallel")
    return tally


# --- system calls that fail ------------------------------------------------------------------------------------------

ERRORS = {
    "openat": ("EACCES", "EMFILE", "ENOSPC"), "write": ("ENOSPC", "EPIPE"), "pwrite64": ("ENOSPC", "EIO"),
    "fdatasync": ("EIO", "ENOSPC"), "fcntl": ("ENOLCK",), "mmap": ("ENOMEM",), "brk": ("ENOMEM",),
    "connect": ("ECONNREFUSED", "ENETUNREACH"), "socket": ("EMFILE",), "sendto": ("EPIPE", "ECONNRESET"),
    "sendmsg": ("EPIPE", "ECONNRESET"), "writev": ("EPIPE", "ECONNRESET"), "recvfrom": ("ECONNRESET", "EAGAIN"),
    "poll": ("ENOMEM", "EINTR"), "ftruncate": ("EIO", "EFBIG"), "rename": ("EROFS",), "getrandom": ("EINTR",),
}
INTERRUPTIBLE = ("openat", "read", "write", "pread64", "pwrite64", "fdatasync", "connect", "sendto", "writev", "fcntl")
# The last two: glibc ends a program whose futex() fails, and takes what brk() gives back for the end of the heap, also when
# strace gave it; memory_limit() is the true test of a heap that cannot grow.
NOT_TO_FAIL = ("execve", "exit_group", "exit", "rt_sigreturn", "arch_prctl", "set_tid_address", "set_robust_list", "rseq", "futex", "brk")


def fail_each_call(world, most=None):
    tally = Tally("a system call fails")
    points = []
    for name, options, targets in VARIANTS[:4]:
        for fresh in (True, False):
            counts = system_calls(world, new_ledger(world, "count", 0 if fresh else 2).folder, options)
            world.witness.drain()
            for call, (before, count) in counts.items():
                if call in NOT_TO_FAIL:
                    continue
                errors = ERRORS.get(call, ("EIO",))
                # Without any lock SQLite tries for 10 s each time.
                ends = ("",) if call == "fcntl" and options else ("", "+")
                whens = [f"{n + 1}{end}" for n in range(before, count) for end in ends]
                points += [(name, options, targets, fresh, call, error, when) for error in errors for when in whens]
                if call in INTERRUPTIBLE:
                    points += [(name, options, targets, fresh, call, "EINTR", f"{n + 1}") for n in range(before, count)]
    trials = []
    old = new_ledger(world, "old", 2)
    for name, options, targets, fresh, call, error, when in sample(points, most):
        ledger = new_ledger(world, "failing") if fresh else old.copy(world.new_folder("failing"))
        inject = ("strace", "-f", "-qq", "-o", "/dev/null", "-e", f"inject={call}:error={error}:when={when}")
        what = f"{name}, {'new' if fresh else 'old'} ledger, {call} {error} #{when}"
        trials.append((ledger, what, (options, targets), {"before": inject}))
    side_by_side(world, trials, tally, at_once=16)
    return tally


# --- files -----------------------------------------------------------------------------------------------------------

def recovers(world, ledger, tally, what):
    run = world.call(ledger.folder)
    check(world, ledger, run, tally, what)
    if run.code != 0:
        tally.report("untrue", f"{what}: still ends with {run.code}: {run.err} {run.results}")


def full_disk(world, rounds):
    """A tmpfs of 512 KiB that is full but for a few bytes; then there is room again."""
    tally = Tally("full disk")
    folder = world.new_folder("small")
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=512k,mode=755", "tmpfs", str(folder)], check=False,
                             capture_output=True).returncode == 0
    if not mounted:
        return tally
    try:
        ledger = None
        for turn in range(rounds):
            if turn % 20 == 0:
                for file in folder.iterdir():
                    file.unlink()
                ledger = Ledger(world.new_folder("unused"))
                ledger.folder = folder
            room = random.choice((0, 4, 8, 12, 16, 20, 24, 32, 48, 64)) * 1024
            free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_bsize
            (folder / "ballast").write_bytes(b"x" * max(0, free - room))
            run = world.call(folder, VARIANTS[turn % 3][1], VARIANTS[turn % 3][2])
            check(world, ledger, run, tally, f"{room} bytes left")
            (folder / "ballast").unlink()
            recovers(world, ledger, tally, "room again")
    finally:
        subprocess.run(["umount", str(folder)], check=True)
    return tally


def file_size_limit(world, rounds):
    tally = Tally("limit of file size")
    ledger = None
    for turn in range(rounds):
        if turn % 20 == 0:
            ledger = new_ledger(world, "limit", 0 if turn % 40 == 0 else 2)
        limit = random.randrange(0, 120_000)
        def preexec(limit=limit):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        run = world.call(ledger.folder, VARIANTS[turn % 3][1], VARIANTS[turn % 3][2], preexec_fn=preexec)
        check(world, ledger, run, tally, f"limit {limit}")
        recovers(world, ledger, tally, "without the limit")
    return tally


def memory_limit(world, rounds):
    """From what the program needs to come up (less is the loader's end, not ours) to more than it needs."""
    tally = Tally("limit of memory")

    def limited(pages):
        return lambda: resource.setrlimit(resource.RLIMIT_AS, (pages * 4096, pages * 4096))

    low, high = 0, 1 << 16
    while high - low > 1:
        middle = (low + high) // 2
        version = subprocess.run([world.binary, "--version"], check=False, capture_output=True, preexec_fn=limited(middle))
        low, high = (low, middle) if version.returncode == 0 else (middle, high)
    for turn in range(rounds):
        if turn % 20 == 0:
            ledger = new_ledger(world, "memory", 0 if turn % 40 == 0 else 2)
        pages = high + random.randrange(0, 160)
        variant = VARIANTS[turn % len(VARIANTS)]
        run = world.call(ledger.folder, variant[1], variant[2], preexec_fn=limited(pages))
        check(world, ledger, run, tally, f"{variant[0]}, {pages - high} pages more than it needs to come up")
        recovers(world, ledger, tally, "without the limit")
    return tally


def read_only(world, rounds):
    """As a user who may read everything and write some of it."""
    tally = Tally("read-only folder or files")
    modes = {"folder": 0o555, "ledger.db": 0o444, "ledger.db-wal": 0o444, "ledger.db-shm": 0o444, "ledger.db.locks": 0o444}
    user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.getuid() == 0 else {}
    for turn in range(rounds):
        ledger = new_ledger(world, "closed", turn % 3)
        protected = random.sample(list(modes), random.randrange(1, 4))
        if turn % 3 == 0:
            protected.append("folder")
        for file in ledger.folder.iterdir():
            if user:
                os.chown(file, NOBODY, NOBODY)
            if file.name in protected:
                file.chmod(modes[file.name])
        if user:
            os.chown(ledger.folder, NOBODY, NOBODY)
        if "folder" in protected:
            ledger.folder.chmod(modes["folder"])
        run = world.call(ledger.folder, **user)
        check(world, ledger, run, tally, f"read-only: {protected}")
        ledger.folder.chmod(0o755)
        for file in ledger.folder.iterdir():
            file.chmod(0o644)
        recovers(world, ledger, tally, "writable again")
    return tally


def hurt(file):
    """One of several kinds of damage. Returns what was done."""
    size = file.stat().st_size
    if size == 0:
        return "was empty"
    with open(file, "r+b") as opened:
        way = random.randrange(4)
        if way == 0:
            length = random.choice((0, random.randrange(size), random.randrange(size) // 1024 * 1024))
            opened.truncate(length)
            return f"cut to {length} of {size}"
        if way == 1:
            place = random.randrange(size)
            opened.seek(place)
            opened.write(os.urandom(random.randrange(1, min(size - place, 2000) + 1)))
            return f"random bytes from {place} of {size}"
        if way == 2:
            places = [random.randrange(size) for _ in range(random.randrange(1, 50))]
            for place in places:
                opened.seek(place)
                byte = opened.read(1)[0]
                opened.seek(place)
                opened.write(bytes([byte ^ (1 << random.randrange(8))]))
            return f"bits flipped at {sorted(places)} of {size}"
        place = random.randrange(size) // 512 * 512
        opened.seek(place)
        opened.write(bytes(min(512, size - place)))
        return f"a sector of zeros at {place} of {size}"


def damage(world, rounds):
    """A ledger that was damaged from outside: refuse it, or go on rightly."""
    tally = Tally("damaged ledger files")
    bases = [new_ledger(world, f"base{calls}", calls) for calls in (1, 9, 40)]
    ends = ("", "", "-wal", "-wal", "-shm", ".locks")
    for turn in range(rounds):
        ledger = random.choice(bases).copy(world.new_folder("damaged"))
        end = ends[turn % len(ends)]
        what = f"ledger.db{end}: {hurt(ledger.folder / f'ledger.db{end}')}"
        for _ in range(2):
            run = world.call(ledger.folder)
            check(world, ledger, run, tally, what)
        shutil.rmtree(ledger.folder)
    return tally


# --- others that are in the way --------------------------------------------------------------------------------------

@contextlib.contextmanager
def held_database(ledger):
    database = sqlite3.connect(ledger.folder / "ledger.db", isolation_level=None)
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
    finally:
        database.execute("ROLLBACK")
        database.close()


@contextlib.contextmanager
def held_topics(ledger):
    with open(ledger.folder / "ledger.db.locks", "r+b") as file:
        whole = struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)
        fcntl.fcntl(file, fcntl.F_OFD_SETLK, whole)
        yield


def stuck_process(world, rounds):
    """Somebody holds SQLite's lock, the topics' locks, or a fleetpub was stopped half-way. All wait at the same time."""
    tally = Tally("locked by a stuck process")
    for _ in range(rounds):
        for held in (held_database, held_topics):
            ledger = new_ledger(world, "stuck", 2)
            with held(ledger):
                processes = [world.start(ledger.folder, options, targets) for _, options, targets in VARIANTS[:3]]
                runs = [world.finish(process) for process in processes]
            for run in runs:
                check(world, ledger, run, tally, held.__name__)
                if run.code != 8:
                    tally.report("untrue", f"{held.__name__}: ended with {run.code}, not 8: {run.err}")
            recovers(world, ledger, tally, "let go")
    return tally


def stopped_process(world, rounds):
    """A fleetpub is stopped (SIGSTOP) at a random moment while another commands the same robot; then goes on."""
    tally = Tally("stopped half-way, then continued")
    for turn in range(rounds):
        ledger = new_ledger(world, "stopped", turn % 2)
        stopped = [world.start(ledger.folder, ("-q", "1")) for _ in range(4)]
        for process in stopped:
            time.sleep(random.uniform(0, 0.01))
            process.send_signal(signal.SIGSTOP)
        others = [world.start(ledger.folder, ("-q", "1")) for _ in range(2)]
        time.sleep(0.1)
        for process in stopped:
            process.send_signal(signal.SIGCONT)
        runs = [world.finish(process) for process in stopped + others]
        seen = world.witness.drain()
        tally.rounds += len(runs)
        tally.seen += len(seen)
        for run in runs:
            tally.ends[end_of(run)] += 1
            check_claims(run, [m for m in seen if f'"{run.action_id}"' in m[3]], tally, "stopped")
        check_ids(ledger, seen, tally, "stopped")
        check_rows(ledger, world.folder / "rows", tally, "stopped")
    return tally


CLOCK = r"""
// A wall clock that runs backwards: each look at it shows an earlier time than the one before.
#define _GNU_SOURCE
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static long behind;
static long Step(void) {
  const char* step = getenv("TORTURE_CLOCK_STEP");
  const char* start = getenv("TORTURE_CLOCK_START");
  if (behind == 0 && start) behind = atol(start);
  return behind += step ? atol(step) : 1;
}
int clock_gettime(clockid_t id, struct timespec* now) {
  int code = (int)syscall(SYS_clock_gettime, id, now);
  if (code == 0 && id == CLOCK_REALTIME) now->tv_sec -= Step();
  return code;
}
int gettimeofday(struct timeval* now, void* zone) {
  (void)zone;
  struct timespec exact;
  clock_gettime(CLOCK_REALTIME, &exact);
  now->tv_sec = exact.tv_sec;
  now->tv_usec = exact.tv_nsec / 1000;
  return 0;
}
time_t time(time_t* out) {
  struct timespec exact;
  clock_gettime(CLOCK_REALTIME, &exact);
  if (out) *out = exact.tv_sec;
  return exact.tv_sec;
}
"""


def backward_clock(world, rounds):
    tally = Tally("clock stepping backwards")
    library = world.folder / "clock.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, "-x", "c", "-"], input=CLOCK, text=True, check=True)
    ledger = new_ledger(world, "clock")
    for turn in range(rounds):
        extra = {"LD_PRELOAD": str(library), "TORTURE_CLOCK_START": str(random.randrange(1, 86_400 * 400)),
                 "TORTURE_CLOCK_STEP": str(random.choice((1, 60, 3_600, 86_400)))}
        _, options, targets = VARIANTS[turn % 4]
        run = world.call(ledger.folder, options, targets, extra=extra)
        check(world, ledger, run, tally, str(extra))
        if run.code != 0:
            tally.report("untrue", f"{extra}: ended with {run.code}: {run.err}")
    return tally

