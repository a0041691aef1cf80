"""What surrounds the program under torture: a broker, a witness of what arrives, a robot, and a way to run it."""

import itertools
import json
import os
import random
import re
import select
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

HANG = 30.0  # seconds after which a call counts as hanging; the longest wait of its own is 10 s
INTERFACE = "torture"
TOPIC = INTERFACE + "/v3/{}/instantActions"
MARKER = INTERFACE + "/marker"
END = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def wait_until(ready, what, seconds=20.0):
    end = time.monotonic() + seconds
    while not ready():
        if time.monotonic() > end:
            raise RuntimeError(f"timed out: {what}")
        time.sleep(0.005)


class Broker:
    """A mosquitto on a free loopback port. A free port cannot be reserved, only tried."""

    def __init__(self, folder):
        self.process = None
        for _ in range(20):
            self.port = random.SystemRandom().randrange(4000, 10000)  # two runs may have one seed
            config, log = folder / "mosquitto.conf", folder / "mosquitto.log"
            config.write_text(
                f"listener {self.port} 127.0.0.1\nallow_anonymous true\nset_tcp_nodelay true\n"
                "max_queued_messages 0\nconnection_messages false\n"
            )
            path = os.environ["PATH"] + ":/usr/sbin"
            command = [shutil.which("mosquitto", path=path) or "mosquitto", "-c", str(config)]
            with open(log, "wb") as err:
                self.process = subprocess.Popen(command, **{**END, "stderr": err})
            try:  # its own word: where another has taken the port, that one would answer
                wait_until(lambda: b" running" in log.read_bytes() or self.process.poll() is not None, "mosquitto")
            except RuntimeError:
                self.stop()
                continue
            if self.process.poll() is None:
                return
        raise RuntimeError("no broker could be started")

    def stop(self):
        self.process.terminate()
        self.process.wait()


class Witness:
    """A real subscriber, mosquitto_sub. `drain` returns what arrived since it was last asked."""

    def __init__(self, port):
        place = ["-h", "127.0.0.1", "-p", str(port)]
        self.sub = subprocess.Popen(
            ["mosquitto_sub", *place, "-t", TOPIC.format("+/+"), "-t", MARKER, "-F", "%t %p"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.pub = subprocess.Popen(
            ["mosquitto_pub", *place, "-t", MARKER, "-l"],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.set_blocking(self.sub.stdout.fileno(), False)
        self.rest = b""
        self.seen = []
        self.markers = 0
        self.last_marker = -1
        try:
            wait_until(self._is_subscribed, "the subscriber")
        except RuntimeError:
            self.stop()
            raise

    def _is_subscribed(self):
        # Any marker will do: to wait for the newest, with a newer one each time, may never end.
        self._mark()
        self._read(0.1)
        return self.last_marker > 0

    def _mark(self):
        self.markers += 1
        self.pub.stdin.write(f"{self.markers}\n".encode())
        self.pub.stdin.flush()

    def _read(self, seconds):
        if not select.select([self.sub.stdout], [], [], seconds)[0]:
            return
        *lines, self.rest = (self.rest + (os.read(self.sub.stdout.fileno(), 1 << 20))).split(b"\n")
        for line in lines:
            topic, payload = line.decode().split(" ", 1)
            if topic == MARKER:
                self.last_marker = int(payload)
            else:
                message = json.loads(payload)
                self.seen.append((topic, message["headerId"], message["actions"][0]["actionId"], payload))

    def drain(self):
        # The broker reads a packet of each connection per turn. What a process that has ended wrote has been read
        # after some turns: each marker is one at least.
        for _ in range(6):
            self._mark()
            end = time.monotonic() + HANG
            while self.last_marker != self.markers:
                self._read(1)
                if time.monotonic() > end:
                    raise RuntimeError("the broker does not answer")
        seen, self.seen = self.seen, []
        return seen

    def stop(self):
        for process in (self.sub, self.pub):
            process.terminate()
            process.wait()


class Run:
    """One call of the program that has ended."""

    def __init__(self, process, code, out, err, killed, hung):
        self.action_id = process.action_id
        self.options = process.options
        self.targets = process.targets
        self.code = code  # negative: the signal that ended it
        self.err = err
        self.killed = killed  # by us
        self.hung = hung
        self.results = []
        for line in out.splitlines():
            try:
                self.results.append(json.loads(line))
            except ValueError:
                pass  # the last line of a killed process


class World:
    def __init__(self, binary):
        self.folder = Path(tempfile.mkdtemp(prefix="fleetpub-torture."))
        self.folder.chmod(0o755)  # an unprivileged user works below it
        self.binary = self.folder / "fleetpub"
        shutil.copy(binary, self.binary)
        self.binary.chmod(0o755)
        self.numbers = itertools.count()
        self.robot = None
        self.broker = Broker(self.folder)
        try:
            self.witness = Witness(self.broker.port)
        except RuntimeError:
            self.broker.stop()
            raise

    def start_robot(self):
        log = self.folder / "robot.log"
        with open(log, "wb") as err:
            self.robot = subprocess.Popen(
                [self.binary, "simulate", "KIT/0001", "--interface", INTERFACE],
                env=self._environment(self.folder), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=err)
        wait_until(lambda: b"online at" in log.read_bytes(), "the robot")

    def stop(self):
        if self.robot:
            self.robot.terminate()
            self.robot.wait()
        self.witness.stop()
        self.broker.stop()
        shutil.rmtree(self.folder)

    def new_folder(self, name):
        folder = self.folder / f"{name}-{next(self.numbers)}"
        folder.mkdir(mode=0o755)
        return folder

    def _environment(self, state):
        return {"PATH": os.environ["PATH"], "HOME": str(state), "FLEETPUB_LEDGER": str(state / "ledger.db"),
                "FLEETPUB_BROKER": f"mqtt://127.0.0.1:{self.broker.port}", "FLEETPUB_INTERFACE": INTERFACE,
                "FLEETPUB_VDA": "3.0.0", "FLEETPUB_CONFIG": "/dev/null"}

    def start(self, state, options=(), targets=("KIT/0001",), before=(), extra=None, **popen):
        """Starts `fleetpub pause TARGET… OPTIONS` with its ledger in `state`. `before`: a command in front of it."""
        action_id = f"t{next(self.numbers)}"
        command = [*before, self.binary, "action", "startPause", *targets, "--vda", "3.0", "--no-check", "-o", "json", "-P", f"call={action_id}", *options]
        if len(targets) == 1:
            command += ["--id", action_id]
        process = subprocess.Popen(command, env={**self._environment(state), **(extra or {})}, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, **popen)
        process.action_id, process.options, process.targets = action_id, options, targets
        return process

    def finish(self, process, kill_after=None, limit=HANG, expect_kill=False):
        hung = False
        try:
            out, err = process.communicate(timeout=limit if kill_after is None else kill_after)
            killed = False
        except subprocess.TimeoutExpired:
            hung = kill_after is None
            killed = True
            os.killpg(process.pid, signal.SIGKILL)
            out, err = process.communicate()
        killed = killed or (expect_kill and process.returncode in (-signal.SIGKILL, 128 + signal.SIGKILL))
        return Run(process, process.returncode, out.decode(errors="replace"),
                   err.decode(errors="replace"), killed, hung)

    def call(self, state, *arguments, **options):
        finishing = {name: options.pop(name) for name in ("kill_after", "limit", "expect_kill") if name in options}
        return self.finish(self.start(state, *arguments, **options), **finishing)


def system_calls(world, state, options):
    """What an undisturbed call asks of the system: name → (how often before the program began, how often in all). The
    dynamic loader comes first; the cache that it gives back is the last that it has to do with."""
    trace = world.folder / "trace"
    run = world.call(state, options, before=("strace", "-f", "-qq", "-o", str(trace)))
    if run.code != 0:
        raise RuntimeError(f"the undisturbed call ended with {run.code}: {run.err}")
    text = trace.read_text(errors="replace")
    names = re.findall(r"^\d+ +(\w+)\(", text, re.M)
    before = names[:names.index("munmap") + 1] if "ld.so.cache" in text else []
    return {name: (before.count(name), names.count(name)) for name in dict.fromkeys(names)}
