"""What is true of tasks on Ray; `tests/engines/ray` runs it."""

import glob
import os
import pathlib
import shutil
import socket
import sys
import tempfile
import time

from driver import Driver, Tasks, environment, expect, expect_loopback, kill, main, parent, say, there, until
from shares import shares

# Ray takes the address of a network for its own unless it believes that no other machine may join.
LOOPBACK = {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0"}


def titled():
    """Processes that Ray has given a title, which takes the place of their environment."""
    found = set()
    for one in there():
        try:
            if pathlib.Path(f"/proc/{one}/cmdline").read_bytes().startswith(b"ray::"):
                found.add(one)
        except OSError:
            pass
    return found


def processes():
    """All that were started by this judge and are there: those have its mark, or are Ray's and new."""
    return [one for one in there() if environment(one).get("ENGINE_JUDGE") == str(os.getpid())] + sorted(titled() - BEFORE["processes"])


def on_this_machine(program, folder):
    tasks = Tasks(folder, "local")
    for at in range(6):
        tasks.add(4 if at < 2 else 0.1, code=3 if at == 4 else 0)
    driver = Driver(program, "ray", tasks)
    until(lambda: len(tasks.noted("begun")) >= 2, 90, "two tasks begin")
    expect_loopback(processes())
    driver.all_done(60, {"slice-5": 3})
    expect(tasks.noted("ended")["t5"] == 1, "a task that failed was done again")
    nothing_stays("after a cluster of its own")
    say(f"on this machine: ready after {driver.ready:.1f} s, over after {driver.taken:.1f} s; it listens on loopback alone; a task that failed is a result")


def files():
    """What Ray and the bridge leave where they are not well-behaved."""
    return {path for pattern in ("/dev/shm/*plasma*", "/tmp/ray", "/tmp/ray-judge-*", tempfile.gettempdir() + "/scenario-runner-ray-*") for path in glob.glob(pattern)}


BEFORE = {"files": files(), "processes": titled()}


def nothing_stays(when, seconds=20):
    try:
        until(lambda: not processes() and files() <= BEFORE["files"], seconds, f"nothing is left {when}")
    except AssertionError as error:
        raise AssertionError(f"{error}: processes {processes()}, files {files() - BEFORE['files']}") from None


def missing(program, folder):
    bare = Tasks(folder, "missing").add(0.1)
    driver = Driver(program, "ray", bare, SCENARIO_RUNNER_PYTHON=shutil.which("python3", path="/usr/bin:/usr/local/bin") or sys.executable, PYTHONPATH="")
    driver.finish(30, 2)
    expect("pip install 'scenario-runner-av[ray]'" in driver.lines[-1], driver.lines)
    first = driver.lines[-1]
    without = pathlib.Path(folder).absolute() / "without"
    (without / "ray").mkdir(parents=True)
    (without / "ray" / "__init__.py").write_text("raise ImportError('No module named ray')\n")
    again = Tasks(folder, "missing-ray").add(0.1)
    driver = Driver(program, "ray", again, PYTHONPATH=f"{without}:{os.environ['PYTHONPATH']}")
    driver.finish(30, 2)
    expect("ray==2.60.0" in driver.lines[-1] and "pip install" in driver.lines[-1], driver.lines)
    expect(not bare.noted("begun") and not again.noted("begun"), "something was done")
    say(f"missing: {first}")
    nobody = Tasks(folder, "nobody").add(0.1)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    driver = Driver(program, "ray", nobody, RAY_ADDRESS=address, RAY_AUTH_TOKEN="1" * 64, **LOOPBACK)
    time.sleep(4)
    driver.interrupt()
    driver.finish(40, 105)
    nothing_stays("of a driver that reached nobody")
    say("nobody at RAY_ADDRESS: Ctrl-C ends the waiting")


def ended_early(program, folder):
    """While a cluster of its own is being started."""
    interrupted = Driver(program, "ray", Tasks(folder, "early-interrupted").add(30))
    killed = Driver(program, "ray", Tasks(folder, "early-killed").add(30))
    time.sleep(3)
    interrupted.interrupt()
    killed.kill()
    interrupted.finish(40, 105)
    nothing_stays("of drivers that ended while they started", 40)
    say(f"Ctrl-C and kill -9 while a cluster is being started: nothing stays, {interrupted.taken:.1f} s after the start")


def two_workers(program, folder):
    from ray.cluster_utils import Cluster

    temporary = tempfile.mkdtemp(prefix="ray-judge-")
    # Where it notes which cluster is there.
    os.environ["RAY_TMPDIR"] = temporary
    os.mkdir(os.path.join(temporary, "ray"))
    cluster = Cluster()
    try:
        cluster.add_node(num_cpus=0, include_dashboard=False, temp_dir=temporary, object_store_memory=80 << 20, node_ip_address="127.0.0.1")
        node = {"num_cpus": 1, "object_store_memory": 80 << 20, "node_ip_address": "127.0.0.1"}
        first = cluster.add_node(**node, resources={"av_stack": 1})
        cluster.add_node(**node)
        cluster.wait_for_nodes(timeout=60)
        expect_loopback(processes())
        say("a cluster of two workers is there, on loopback alone")
        address = {"RAY_ADDRESS": cluster.address}
        # Ray tries for 20 s before it gives up with another token.
        token = with_another_token(program, folder, address)
        many(program, folder, address)
        stack(program, folder, address)
        driver_killed(program, folder, address)
        interrupted(program, folder, address)
        worker_killed(program, folder, address)
        refused_token(*token)
        shares(folder, "ray", **address)
        node_killed(program, folder, address, cluster, first)
    finally:
        cluster.shutdown()
        shutil.rmtree(temporary, ignore_errors=True)


def with_another_token(program, folder, address):
    tasks = Tasks(folder, "token").add(0.1)
    return tasks, Driver(program, "ray", tasks, **address, RAY_AUTH_TOKEN="2" * 64)


def refused_token(tasks, driver):
    driver.finish(60, 2)
    expect(not tasks.noted("begun"), "a task was done with another token")
    say(f"another token is refused: {' '.join(driver.lines)[:160]}")


def many(program, folder, address):
    tasks = Tasks(folder, "many")
    for _ in range(200):
        tasks.add(0.005)
    driver = Driver(program, "ray", tasks, **address)
    driver.all_done(90)
    expect(set(tasks.noted("ended").values()) == {1} and len(tasks.noted("ended")) == 200, "not each once")
    each = (driver.taken - driver.ready) / 200
    say(f"200 tasks of 5 ms: ready after {driver.ready:.1f} s, then {1000 * each:.0f} ms each")


def stack(program, folder, address):
    tasks = Tasks(folder, "stack").add(1).add(1).add(1)
    driver = Driver(program, "ray", tasks, **address, TASK_RESOURCES='{"av_stack": 1}')
    driver.all_done(60)
    lines = [line.split()[0] for line in tasks.notes.read_text().splitlines()]
    expect(lines == ["begun", "ended"] * 3, f"two at once have the one stack: {lines}")
    unmet = Tasks(folder, "unmet").add(0.1)
    driver = Driver(program, "ray", unmet, **address, TASK_RESOURCES='{"no_such": 1}')
    until(lambda: "notice no node has no_such: 1; its tasks wait until one joins" in driver.lines, 30, "what no node has is said")
    driver.interrupt()
    driver.finish(40, 105)
    say("a controller's stack is a resource: one at a time; one that no node has is named")


def driver_killed(program, folder, address):
    tasks = Tasks(folder, "driver").add(6).add(6).add(0.1)
    driver = Driver(program, "ray", tasks, **address)
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    driver.kill()
    gone = until(lambda: not tasks.processes(), 20, "the tasks of a driver that was killed are ended")
    driver = Driver(program, "ray", tasks, **address)
    driver.all_done(60)
    say(f"the driver killed -9: its tasks were gone after {gone:.1f} s, and another driver did all in {driver.taken:.1f} s")


def interrupted(program, folder, address):
    tasks = Tasks(folder, "interrupted").add(30).add(30).add(30)
    driver = Driver(program, "ray", tasks, **address)
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    begun = time.monotonic()
    driver.interrupt()
    driver.finish(40, 105)
    taken = time.monotonic() - begun
    until(lambda: not tasks.processes(), 5, "no task is left after Ctrl-C")
    time.sleep(1)
    expect(len(tasks.noted("begun")) == 2 and not tasks.noted("ended"), "something went on after Ctrl-C")
    say(f"Ctrl-C: nothing is left after {taken:.1f} s")


def worker_killed(program, folder, address):
    tasks = Tasks(folder, "worker").add(4).add(4).add(0.1, code=7)
    driver = Driver(program, "ray", tasks, **address)
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    task = tasks.processes()[0]
    # The task's parent is Ray's worker.
    kill(parent(task))
    gone = until(lambda: task not in tasks.processes(), 5, "a task goes with its worker")
    driver.all_done(60, {"slice-3": 7})
    begun = tasks.noted("begun")
    expect(sorted(begun.values()) == [1, 1, 2], f"begun: {begun}")
    expect(set(tasks.noted("ended").values()) == {1}, "one ended twice")
    say(f"a worker killed -9: its task was gone after {gone:.1f} s and done again, the failed one was not; over after {driver.taken - driver.ready:.1f} s instead of 4")


def node_killed(program, folder, address, cluster, node):
    tasks = Tasks(folder, "node").add(5).add(5).add(5)
    driver = Driver(program, "ray", tasks, **address)
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    cluster.remove_node(node, allow_graceful=False)
    driver.all_done(120)
    expect(all(count == 1 for count in tasks.noted("ended").values()), "one ended twice")
    expect(sum(tasks.noted("begun").values()) == 4, f"begun: {tasks.noted('begun')}")
    say(f"a node killed -9: nothing lost; over after {driver.taken - driver.ready:.1f} s instead of 10")


def checks(program, folder):
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    os.environ["ENGINE_JUDGE"] = str(os.getpid())
    os.environ["SCENARIO_RUNNER_PYTHON"] = sys.executable
    try:
        on_this_machine(program, folder)
        missing(program, folder)
        ended_early(program, folder)
        os.environ.update(LOOPBACK, RAY_AUTH_MODE="token", RAY_AUTH_TOKEN="1" * 64)
        two_workers(program, folder)
        nothing_stays("at the end")
    finally:
        for one in processes():
            kill(one)


if __name__ == "__main__":
    main(checks)
