"""Has scenario-runner's tasks done on Ray: it is started by the program, which writes tasks as lines and reads lines of what came of them.

    {"id": "slice-1", "argv": ["/opt/scenario-runner", "exec", …], "out": "/shared/slice-1.out", "cpus": 1, "resources": {"av_stack": 1}}
    {"id": "slice-1", "rc": 0, "node": "worker-3", "s": 131.2}

The cluster is the one that RAY_ADDRESS names. Without it, one is started on this machine, on loopback alone and with a token of its own, and
is gone afterwards. The end of standard input is that of the program: all tasks are ended then. Workers need Ray and nothing of this package.
"""

import json
import os
import queue
import secrets
import shutil
import signal
import sys
import tempfile
import threading
import time

from . import _streams

RAY = "2.60.0"  # as in pyproject.toml, and in src/engines/ray.rs
PYTHONS = ((3, 10), (3, 13))  # those for which there is such a Ray, first and last
PROTOCOL = 1
TIME_TO_START = 20.0  # that a cluster of its own is given until it can be ended in good order, s
LOST = 3  # times that a task whose worker is lost is done again
INSTALL = f"install it for {sys.executable}: pip install 'scenario-runner-av[ray]' (ray=={RAY})"


class Wrong(Exception):
    """What the program is told instead of results: under which key, and what."""

    def __init__(self, key, text):
        super().__init__(text)
        self.key = key


def prepare(environment):
    """Sets what Ray reads of the environment once it is imported."""
    environment["RAY_USAGE_STATS_ENABLED"] = "0"
    environment.setdefault("RAY_AUTH_MODE", "token")
    if not environment.get("RAY_ADDRESS"):
        environment["RAY_AUTH_MODE"] = "token"
        environment["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
        # Ray takes the address of a network for its own, and listens on all of them, wherever it believes that others may join.
        environment["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"


def imported(version=sys.version_info, load=lambda: __import__("ray")):
    """Ray, if it is the one that is spoken with."""
    first, last = PYTHONS
    if not first <= tuple(version[:2]) <= last:
        there = ".".join(map(str, version[:3]))
        range_ = "{}.{} to {}.{}".format(*first, *last)
        raise Wrong("missing", f"{sys.executable} is Python {there}, and Ray {RAY} is there for {range_}: name another by SCENARIO_RUNNER_PYTHON")
    try:
        ray = load()
    except ImportError as error:
        raise Wrong("missing", f"Ray is not there ({error}): {INSTALL}") from error
    if ray.__version__ != RAY:
        raise Wrong("missing", f"Ray {ray.__version__} is there, and {RAY} is needed: {INSTALL}")
    return ray


def connect(ray, folder, environment):
    """Begins to speak with the cluster, and says in a few words which it is."""
    address = environment.get("RAY_ADDRESS")
    if address and "://" in address:
        raise Wrong("wrong", f"RAY_ADDRESS={address} would go through Ray's client, which is not supported: run this on a machine of the cluster, with RAY_ADDRESS=HOST:PORT")
    try:
        if address:
            ray.init(address=address, log_to_driver=False, logging_level="ERROR", namespace="scenario-runner")
        else:
            ray.init(
                address="local",
                include_dashboard=False,
                log_to_driver=False,
                logging_level="ERROR",
                object_store_memory=80 << 20,  # the least that Ray takes; results of tasks have a few bytes
                _temp_dir=folder,
                _node_ip_address="127.0.0.1",
            )
    except Exception as error:  # whatever Ray raises: versions that differ, a token that is refused, nobody there
        raise Wrong("wrong", f"Ray cannot be reached at {address or 'this machine'}: {type(error).__name__}: {error}") from error
    nodes = sum(1 for node in ray.nodes() if node["Alive"])
    cpus = ray.cluster_resources().get("CPU", 0)
    place = f"at {address}" if address else "on this machine"
    return f"Ray {ray.__version__} {place}: {nodes} {'node' if nodes == 1 else 'nodes'}, {cpus:g} cores"


def do_task(argv, out):
    """Runs a command to its end, on a worker: exit code, node and seconds. What it starts is ended with it, and all of it with the worker.

    It is sent to workers as it stands here, so it names nothing of this file.
    """
    import os
    import signal
    import socket
    import subprocess
    import time

    begun = time.monotonic()
    with open(out, "wb") as said:
        # It ends the group once this process is gone, however it went.
        watching = subprocess.Popen(
            ["/bin/sh", "-c", 'read -r group && { read -r _; kill -s KILL -- "-$group"; }'],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            try:
                child = subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True)
            except OSError as error:
                said.write(f"{argv[0]}: {error.strerror}\n".encode())
                # As shells say it.
                return 127 if isinstance(error, FileNotFoundError) else 126, socket.gethostname(), time.monotonic() - begun
            try:
                watching.stdin.write(f"{child.pid}\n".encode())
                watching.stdin.flush()
                # Whoever has been waited for may have given its number to another: the group is ended before.
                os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
            finally:
                watching.kill()
                watching.wait()
                try:
                    os.killpg(child.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                code = child.wait()
        finally:
            watching.kill()
            watching.wait()
            watching.stdin.close()
    return code if code >= 0 else 128 - code, socket.gethostname(), time.monotonic() - begun


def read_tasks(requests, tasks):
    """Puts what is asked into a queue, and None once nobody asks any more."""
    try:
        for line in requests:
            tasks.put(json.loads(line))
    finally:
        tasks.put(None)


class Work:
    """Tasks that Ray was given, and those that it has ended."""

    def __init__(self, ray, tell):
        self.ray = ray
        self.tell = tell
        self.remote = ray.remote(do_task)
        self.open = {}
        self.unmet = set()

    def submit(self, task):
        """Gives Ray a task."""
        resources = task.get("resources", {})
        options = self.remote.options(
            num_cpus=task["cpus"],
            resources=resources,
            # Of lost workers alone: what raises is not done again.
            max_retries=LOST,
            retry_exceptions=False,
            name=task["id"],
        )
        self.say_unmet({"CPU": task["cpus"], **resources})
        self.open[options.remote(task["argv"], task["out"])] = task["id"]

    def say_unmet(self, needs):
        """Says once of each resource that no node has as much of it as a task takes: such a task waits until one joins."""
        most = {}
        for node in self.ray.nodes():
            if node["Alive"]:
                for name, much in node["Resources"].items():
                    most[name] = max(most.get(name, 0), much)
        for name, much in needs.items():
            if most.get(name, 0) < much and (name, much) not in self.unmet:
                self.unmet.add((name, much))
                self.tell({"notice": f"no node has {name}: {much:g}; its tasks wait until one joins"})

    def tell_ended(self, seconds):
        """Tells of tasks that end within this time."""
        ended, _ = self.ray.wait(list(self.open), num_returns=1, timeout=seconds)
        for reference in ended:
            task = self.open.pop(reference)
            try:
                rc, node, taken = self.ray.get(reference)
            except Exception as error:  # of Ray: the worker was lost too often; of the task: its output cannot be written
                self.tell({"id": task, "lost": f"{type(error).__name__}: {str(error).strip()}"})
            else:
                self.tell({"id": task, "rc": rc, "node": node, "s": round(taken, 3)})

    def cancel(self):
        """Ends all that is not over."""
        for reference in self.open:
            self.ray.cancel(reference, force=True)
        if self.open:
            # What could not be ended ends with the driver, which this process is.
            self.ray.wait(list(self.open), num_returns=len(self.open), timeout=5)


def converse(ray, tasks, tell):
    """Does what is asked until nobody asks any more."""
    work = Work(ray, tell)
    try:
        while True:
            try:
                # Without anything to wait for, the next line is waited for.
                while True:
                    task = tasks.get(block=not work.open)
                    if task is None:
                        return
                    work.submit(task)
            except queue.Empty:
                pass
            work.tell_ended(0.1)
    finally:
        work.cancel()


def descendants(process):
    """What a process has started, and what that has, as Linux tells it."""
    children = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="utf-8", errors="replace") as file:
                parent = int(file.read().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        children.setdefault(parent, []).append(int(name))
    found = list(children.get(process, ()))
    for one in found:
        found.extend(children.get(one, ()))
    return found


def kill(processes):
    """Ends those that are there."""
    for one in processes:
        try:
            os.kill(one, signal.SIGKILL)
        except ProcessLookupError:
            pass


def remove(folder):
    """Removes what Ray has left; its processes may be writing their last."""
    for _ in range(50):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.exists(folder):
            return
        time.sleep(0.1)


def main():
    """Speaks with the program that started this one."""
    requests, answers = _streams.take()

    def tell(said):
        answers.write(json.dumps(said).encode() + b"\n")
        answers.flush()

    tasks = queue.Queue()
    folder = tempfile.mkdtemp(prefix="scenario-runner-ray-")
    connected = threading.Event()

    def hear():
        try:
            read_tasks(requests, tasks)
        finally:
            # Ray may take minutes to find that nobody is there, and hears no signal meanwhile.
            if not connected.wait(1.0 if os.environ.get("RAY_ADDRESS") else TIME_TO_START):
                # Ray's agents would notice only after a while that what has started them is gone.
                kill(descendants(os.getpid()))
                remove(folder)
                os._exit(1)

    threading.Thread(target=hear, daemon=True).start()
    ray = None
    try:
        prepare(os.environ)
        ray = imported()
        ready = connect(ray, folder, os.environ)
        connected.set()
        tell({"ready": ready, "ray": ray.__version__, "protocol": PROTOCOL})
        converse(ray, tasks, tell)
    except Wrong as wrong:
        connected.set()
        tell({wrong.key: str(wrong)})
        return 1
    except BrokenPipeError:
        # The program is gone.
        return 1
    finally:
        if ray is not None:
            ray.shutdown()
        remove(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
