"""What the judges of both engines share: tasks that note what is done of them, and the driver that has them done."""

import glob
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

BEGUN = time.monotonic()

# Notes its beginning and its end, and ends with the exit code that it is given.
TASK = """#!/bin/sh
printf 'begun %s %s\\n' "$2" $$ >>"$1"
sleep "$3"
printf 'ended %s %s\\n' "$2" $$ >>"$1"
exit "$4"
"""


def say(text):
    """With the seconds since the beginning."""
    print(f"{time.monotonic() - BEGUN:6.1f} s  {text}", flush=True)


def expect(holds, otherwise):
    if not holds:
        raise AssertionError(otherwise)


def until(holds, seconds, what):
    """Waits until something holds; how long that took."""
    begun = time.monotonic()
    while not holds():
        expect(time.monotonic() - begun < seconds, f"not within {seconds} s: {what}")
        time.sleep(0.1)
    return time.monotonic() - begun


def there():
    """All other processes of this machine."""
    return [int(name) for name in os.listdir("/proc") if name.isdigit() and int(name) != os.getpid()]


def environment(process):
    """That with which a process was started."""
    try:
        text = pathlib.Path(f"/proc/{process}/environ").read_bytes().decode(errors="replace")
    except OSError:
        return {}
    return dict(pair.split("=", 1) for pair in text.split("\0") if "=" in pair)


def parent(process):
    """The process that started it, or who has taken its place."""
    try:
        return int(pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 0


def kill(*processes):
    """Ends those that are still there, all at once: none goes on because another one that it waits for has ended."""
    for what in (signal.SIGSTOP, signal.SIGKILL):
        for process in processes:
            try:
                os.kill(process, what)
            except ProcessLookupError:
                pass


def expect_loopback(processes):
    """These listen, and where nobody else can reach them."""
    inodes = set()
    for process in processes:
        for link in glob.glob(f"/proc/{process}/fd/*"):
            try:
                inodes.add(os.readlink(link))
            except OSError:
                pass
    lines = [line.split() for name in ("tcp", "tcp6") for line in pathlib.Path(f"/proc/net/{name}").read_text().splitlines()[1:]]
    found = {words[1].rsplit(":", 1)[0] for words in lines if words[3] == "0A" and f"socket:[{words[9]}]" in inodes}
    # 127.0.0.1, ::ffff:127.0.0.1 and ::1 as /proc writes them.
    expect(found and found <= {"0100007F", "0000000000000000FFFF00000100007F", "00000000000000000000000001000000"}, f"it listens on {found}")


class Tasks:
    """Tasks of one folder, and what they have noted."""

    def __init__(self, folder, name):
        self.folder = pathlib.Path(folder).absolute() / name
        self.folder.mkdir(parents=True)
        self.notes = self.folder / "notes"
        self.script = self.folder / "task.sh"
        self.script.write_text(TASK)
        self.script.chmod(0o755)
        self.argv = []

    def add(self, seconds, code=0):
        self.argv.append([str(self.script), str(self.notes), f"t{len(self.argv) + 1}", str(seconds), str(code)])
        return self

    def write(self):
        path = self.folder / "tasks"
        path.write_text("".join(json.dumps(one) + "\n" for one in self.argv))
        return path

    def noted(self, what):
        """How often each task has begun or ended."""
        counts = {}
        for line in self.notes.read_text().splitlines() if self.notes.exists() else []:
            kind, name, _ = line.split()
            if kind == what:
                counts[name] = counts.get(name, 0) + 1
        return counts

    def processes(self):
        """Those of this folder's tasks that are there."""
        found = []
        for process in there():
            try:
                words = pathlib.Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if str(self.script).encode() in words:
                found.append(process)
        return found


class Driver:
    """A process that has tasks done on an engine."""

    def __init__(self, program, engine, tasks, *options, **environment):
        self.lines = []
        self.tasks = tasks
        self.child = subprocess.Popen(
            [program, engine, str(tasks.folder / "engine"), str(tasks.write()), *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            env={**os.environ, **environment},
            start_new_session=True,
            text=True,
        )
        self.begun = time.monotonic()
        self.ready = None
        self.reading = threading.Thread(target=self._read, daemon=True)
        self.reading.start()

    def _read(self):
        for line in self.child.stdout:
            if line.startswith("ready") and self.ready is None:
                self.ready = time.monotonic() - self.begun
            self.lines.append(line.rstrip("\n"))

    def finish(self, seconds, code=0):
        """Waits until it has ended with this exit code; what it told of tasks, by their names."""
        try:
            self.child.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"the driver did not end within {seconds} s:\n" + "\n".join(self.lines)) from None
        self.reading.join()
        self.taken = time.monotonic() - self.begun
        expect(self.child.returncode == code, f"exit code {self.child.returncode} instead of {code}:\n" + "\n".join(self.lines))
        ended = {}
        for line in self.lines:
            kind, *words = line.split(" ")
            if kind in ("ended", "lost"):
                expect(words[0] not in ended, f"told twice: {line}")
                ended[words[0]] = (kind, words[1:])
        return ended

    def all_done(self, seconds, codes=None):
        """Waits until all tasks have ended, with these exit codes by name, otherwise 0."""
        ended = self.finish(seconds)
        names = [f"slice-{at + 1}" for at in range(len(self.tasks.argv))]
        expect(sorted(ended) == sorted(names), f"ended: {sorted(ended)}")
        for name in names:
            wanted = str((codes or {}).get(name, 0))
            expect(ended[name][0] == "ended" and ended[name][1][0] == wanted, f"{name}: {ended[name]}, wanted {wanted}")
        return ended

    def interrupt(self):
        self.child.send_signal(signal.SIGINT)

    def kill(self):
        self.child.kill()
        self.child.wait()


def main(checks):
    """Makes the checks, and says what is wrong."""
    try:
        checks(*sys.argv[1:])
    except AssertionError as error:
        say(f"WRONG: {error}")
        sys.exit(1)
