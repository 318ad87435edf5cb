"""The bridge to Ray, with a stub in Ray's place."""

import io
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest

from scenario_runner_av import ray as bridge


class Lost(Exception):
    """As Ray's where a worker is lost too often."""


class Remote:
    def __init__(self, stub, function):
        self.stub = stub
        self.function = function

    def options(self, **options):
        self.stub.options.append(options)
        return self

    def remote(self, *arguments):
        self.stub.given.append(arguments)
        return len(self.stub.given) - 1


class Stub:
    """What the bridge uses of Ray. Tasks end in the order in which they were given, as `ends` says."""

    __version__ = bridge.RAY

    def __init__(self, ends=(), resources=None):
        self.ends = ends
        self.resources = resources or {"CPU": 2.0}
        self.options, self.given, self.cancelled, self.initialised = [], [], [], []

    def init(self, **options):
        self.initialised.append(options)

    def nodes(self):
        return [{"Alive": True, "Resources": self.resources}, {"Alive": False, "Resources": {"no_such": 9.0}}]

    def cluster_resources(self):
        return self.resources

    def remote(self, function):
        return Remote(self, function)

    def wait(self, references, num_returns, timeout):
        ready = [one for one in references if one < len(self.ends)][:num_returns]
        if not ready:
            time.sleep(min(timeout, 0.01))
        return ready, []

    def get(self, reference):
        end = self.ends[reference]
        if isinstance(end, Exception):
            raise end
        return end

    def cancel(self, reference, force):
        self.cancelled.append((reference, force))


def task(name, **more):
    return {"id": name, "argv": ["/bin/true"], "out": "/out", "cpus": 1, **more}


def told(stub, *asked):
    """What is told where the program asks for these and then is gone, once all that ends has been told of."""
    said = []
    tasks = queue.Queue()
    for one in asked:
        tasks.put(one)

    def tell(line):
        said.append(line)
        if sum("id" in line for line in said) == len(stub.ends):
            tasks.put(None)

    if not stub.ends:
        tasks.put(None)
    bridge.converse(stub, tasks, tell)
    return said


class Conversation(unittest.TestCase):
    def test_an_exit_code_is_a_result_and_a_lost_worker_is_not(self):
        stub = Stub(ends=[(0, "one", 1.5), (3, "two", 0.25), Lost("the worker died")])
        said = told(stub, task("a"), task("b"), task("c"))
        self.assertEqual(
            said,
            [
                {"id": "a", "rc": 0, "node": "one", "s": 1.5},
                {"id": "b", "rc": 3, "node": "two", "s": 0.25},
                {"id": "c", "lost": "Lost: the worker died"},
            ],
        )
        self.assertEqual(stub.cancelled, [])

    def test_lost_workers_alone_are_tried_again(self):
        stub = Stub(ends=[(1, "one", 0.1)], resources={"CPU": 4.0, "av_stack": 1.0})
        told(stub, task("a", cpus=2, resources={"av_stack": 1}))
        self.assertEqual(stub.options, [{"num_cpus": 2, "resources": {"av_stack": 1}, "max_retries": 3, "retry_exceptions": False, "name": "a"}])

    def test_what_no_living_node_has_is_said_once(self):
        needs = {"no_such": 1}
        said = told(Stub(ends=[(0, "one", 0.1)] * 2), task("a", resources=needs), task("b", resources=needs))
        notices = [line["notice"] for line in said if "notice" in line]
        self.assertEqual(notices, ["no node has no_such: 1; its tasks wait until one joins"])

    def test_all_that_is_not_over_is_ended_with_the_program(self):
        stub = Stub()
        self.assertEqual(told(stub, task("a"), task("b")), [])
        self.assertEqual(stub.cancelled, [(0, True), (1, True)])

    def test_a_line_that_was_cut_off_ends_the_asking(self):
        tasks = queue.Queue()
        with self.assertRaises(ValueError):
            bridge.read_tasks(io.BytesIO(json.dumps(task("a")).encode() + b'\n{"id": "b'), tasks)
        self.assertEqual([tasks.get(), tasks.get()], [task("a"), None])


class Versions(unittest.TestCase):
    def missing(self, **options):
        with self.assertRaises(bridge.Wrong) as caught:
            bridge.imported(**options)
        self.assertEqual(caught.exception.key, "missing")
        return str(caught.exception)

    def test_what_to_install_is_said(self):
        def load():
            raise ImportError("No module named 'ray'")

        said = self.missing(version=(3, 11, 7), load=load)
        self.assertIn("pip install 'scenario-runner-av[ray]'", said)
        self.assertIn(f"ray=={bridge.RAY}", said)

    def test_another_ray_and_another_python_are_refused(self):
        other = types.SimpleNamespace(__version__="2.9.3")
        self.assertIn("Ray 2.9.3 is there, and 2.60.0 is needed", self.missing(version=(3, 11, 7), load=lambda: other))
        for version in ((3, 9, 2), (3, 14, 0)):
            self.assertIn("is there for 3.10 to 3.13", self.missing(version=version, load=Stub))
        self.assertIsInstance(bridge.imported(version=(3, 13, 1), load=Stub), Stub)

    def test_it_is_the_version_of_the_extra_and_of_the_program(self):
        root = os.path.join(os.path.dirname(__file__), "..", "..", "..")
        for path, line in (
            ("sdk/python/pyproject.toml", f'ray = ["ray=={bridge.RAY}"]'),
            ("src/engines/ray.rs", f'pub const RAY_VERSION: &str = "{bridge.RAY}";'),
            ("tests/engines/ray.txt", f"ray=={bridge.RAY}"),
        ):
            with open(os.path.join(root, path), encoding="utf-8") as file:
                self.assertIn(line, file.read().splitlines(), path)


class Environment(unittest.TestCase):
    def test_a_cluster_of_its_own_has_a_token_and_is_on_loopback(self):
        first, second = {"RAY_AUTH_MODE": "disabled"}, {}
        bridge.prepare(first)
        bridge.prepare(second)
        self.assertEqual(first["RAY_AUTH_MODE"], "token")
        self.assertNotEqual(first["RAY_AUTH_TOKEN"], second["RAY_AUTH_TOKEN"])
        self.assertEqual((first["RAY_USAGE_STATS_ENABLED"], first["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"]), ("0", "0"))
        stub = Stub()
        bridge.connect(stub, "/tmp/folder", first)
        self.assertEqual((stub.initialised[0]["address"], stub.initialised[0]["_node_ip_address"]), ("local", "127.0.0.1"))

    def test_a_cluster_that_is_named_is_asked_with_its_own_token(self):
        environment = {"RAY_ADDRESS": "head:6379", "RAY_AUTH_TOKEN": "theirs"}
        bridge.prepare(environment)
        self.assertEqual((environment["RAY_AUTH_MODE"], environment["RAY_AUTH_TOKEN"]), ("token", "theirs"))
        self.assertNotIn("RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER", environment)
        stub = Stub()
        self.assertEqual(bridge.connect(stub, "/tmp/folder", environment), "Ray 2.60.0 at head:6379: 1 node, 2 cores")
        self.assertEqual(stub.initialised[0]["address"], "head:6379")

    def test_the_client_is_refused(self):
        with self.assertRaises(bridge.Wrong) as caught:
            bridge.connect(Stub(), "/tmp/folder", {"RAY_ADDRESS": "ray://head:10001"})
        self.assertIn("RAY_ADDRESS=HOST:PORT", str(caught.exception))


@unittest.skipUnless(sys.platform == "linux", "workers run Linux")
class Commands(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.out = os.path.join(folder.name, "out")

    def said(self):
        with open(self.out, encoding="utf-8") as file:
            return file.read()

    def test_exit_codes_are_those_of_shells(self):
        for command, code in (("exit 3", 3), ("kill -9 $$", 137), ("echo said; echo also >&2", 0)):
            self.assertEqual(bridge.do_task(["/bin/sh", "-c", command], self.out)[0], code)
        self.assertEqual(self.said(), "said\nalso\n")
        self.assertEqual(bridge.do_task(["/no/such/program"], self.out)[0], 127)
        self.assertEqual(bridge.do_task([self.folder], self.out)[0], 126)
        self.assertIn(self.folder, self.said())

    def test_output_that_cannot_be_written_is_no_exit_code(self):
        with self.assertRaises(OSError):
            bridge.do_task(["/bin/true"], os.path.join(self.folder, "no", "out"))

    def test_what_a_task_leaves_behind_is_ended_with_it(self):
        note = os.path.join(self.folder, "note")
        bridge.do_task(["/bin/sh", "-c", f"sleep 60 & echo $! >{note}"], self.out)
        with open(note, encoding="utf-8") as file:
            self.assertTrue(gone(int(file.read())))

    def test_what_was_started_by_what_was_started_is_found_and_ended(self):
        note = os.path.join(self.folder, "note")
        child = subprocess.Popen(["/bin/sh", "-c", f"sleep 60 & echo $! >{note}.new; mv {note}.new {note}; wait"], start_new_session=True)
        while not os.path.exists(note):
            time.sleep(0.05)
        with open(note, encoding="utf-8") as file:
            grandchild = int(file.read())
        found = bridge.descendants(os.getpid())
        self.assertLess(found.index(child.pid), found.index(grandchild))
        bridge.kill(found)
        child.wait()
        self.assertTrue(gone(grandchild))

    def test_a_task_ends_with_its_worker_however_that_ended(self):
        note = os.path.join(self.folder, "note")
        script = f"from scenario_runner_av.ray import do_task; do_task(['/bin/sh', '-c', 'echo $$ >{note}.new; mv {note}.new {note}; sleep 60; true'], {self.out!r})"
        worker = subprocess.Popen([sys.executable, "-c", script])
        until = time.monotonic() + 20
        while not os.path.exists(note) and time.monotonic() < until:
            time.sleep(0.05)
        with open(note, encoding="utf-8") as file:
            process = int(file.read())
        time.sleep(0.5)
        self.assertFalse(gone(process, 0))
        worker.send_signal(signal.SIGKILL)
        worker.wait()
        self.assertTrue(gone(process))


def gone(process, seconds=10):
    """Whether a process has ended, at the latest within this time."""
    until = time.monotonic() + seconds
    while True:
        try:
            with open(f"/proc/{process}/stat", encoding="utf-8") as file:
                if file.read().rsplit(")", 1)[1].split()[0] == "Z":
                    return True
        except OSError:
            return True
        if time.monotonic() >= until:
            return False
        time.sleep(0.05)


if __name__ == "__main__":
    unittest.main()
