"""What is true of tasks on Slurm; `tests/engines/slurm` runs it."""

import json
import os
import shutil
import time

from driver import Driver, Tasks, expect, expect_loopback, main, say, until
from shares import shares
from slurm_cluster import Cluster


def sets_up(cluster):
    """What a driver finds in its environment."""
    return {name: cluster.environment[name] for name in ("LD_LIBRARY_PATH", "PATH", "SLURM_CONF")}


def queue(cluster, tasks=None):
    """What is in the queue, all of it or that of these tasks: pairs of a place and a state."""
    places = [tuple(line.split()) for line in cluster.ask("squeue", "-h", "-r", "-o", "%i %t").splitlines()]
    if tasks is None:
        return places
    jobs = [array["job"] for array in json.loads((tasks.folder / "engine" / "slurm.json").read_text())["arrays"]]
    return [(place, state) for place, state in places if place.split("_")[0] in jobs]


def missing(program, folder):
    tasks = Tasks(folder, "missing").add(0.1)
    driver = Driver(program, "slurm", tasks, PATH="/nowhere")
    driver.finish(20, 2)
    expect("there is no `sbatch` here" in driver.lines[-1] and "slurm-client" in driver.lines[-1], driver.lines)
    say(f"missing: {driver.lines[-1]}")


def stubs(folder, name, **scripts):
    """Clients that do this in place of Slurm's; what a driver finds in its environment."""
    place = os.path.join(folder, name)
    os.makedirs(place)
    for client, script in {"squeue": "exit 0", "scancel": "exit 0", **scripts}.items():
        path = os.path.join(place, client)
        with open(path, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\n{script}\n")
        os.chmod(path, 0o755)
    return place, {"PATH": f"{place}:{os.environ['PATH']}", "ENGINE_SETTLE": "1"}


def given_up(program, folder):
    """A job that leaves the queue without an exit code, whenever it is submitted."""
    place, environment = stubs(folder, "leaves", sbatch='[ "$1" = --version ] && exit 0; echo x >>"$(dirname "$0")/submitted"; wc -l <"$(dirname "$0")/submitted"')
    tasks = Tasks(folder, "given_up").add(0.1)
    driver = Driver(program, "slurm", tasks, **environment)
    ended = driver.finish(60)
    submitted = open(os.path.join(place, "submitted"), encoding="utf-8").read().count("x")
    expect(ended["slice-1"][0] == "lost" and submitted == 4, f"{submitted} times: {driver.lines}")
    expect(driver.lines[-1] == "done 1 failed 1", driver.lines)
    say("a task that leaves the queue four times without an exit code is given up, and has failed")


def silent(program, folder):
    """A queue that cannot be read is not an empty one."""
    # The last argument is the script.
    submit = """[ "$1" = --version ] && exit 0
echo x >>"$(dirname "$0")/submitted"
for script; do :; done
(sleep 4; for at in 0 1; do SLURM_ARRAY_TASK_ID=$at SLURM_JOB_ID=7 sh -c "$script"; done) >/dev/null 2>&1 &
echo 7"""
    place, environment = stubs(folder, "silent", sbatch=submit, squeue="echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1")
    tasks = Tasks(folder, "unheard").add(0.1).add(0.1, code=3)
    driver = Driver(program, "slurm", tasks, **environment)
    driver.all_done(60, {"slice-2": 3})
    submitted = open(os.path.join(place, "submitted"), encoding="utf-8").read().count("x")
    expect(submitted == 1 and set(tasks.noted("begun").values()) == {1}, f"{submitted} times: {driver.lines}")
    driver = Driver(program, "slurm", Tasks(folder, "stuck").add(0.1), **environment)
    time.sleep(1)
    driver.interrupt()
    driver.finish(30, 2)
    expect("it may go on" in driver.lines[-1] and "scancel 7" in driver.lines[-1], driver.lines)
    say("a queue that cannot be read is not taken for an empty one, and nobody says then that nothing goes on")


def refused(program, folder, cluster):
    tasks = Tasks(folder, "refused").add(0.1)
    driver = Driver(program, "slurm", tasks, "--partition=none", **sets_up(cluster))
    driver.finish(20, 2)
    expect("invalid partition specified" in "\n".join(driver.lines), driver.lines)
    driver = Driver(program, "slurm", tasks, "--wait", **sets_up(cluster))
    driver.finish(20, 2)
    expect("is set by scenario-runner itself" in driver.lines[-1], driver.lines)
    expect(not queue(cluster) and not tasks.noted("begun"), "something was submitted")
    say("a partition that there is not and an option that is ours are refused, and nothing is in the queue")


def done(program, folder, cluster):
    tasks = Tasks(folder, "done")
    for at in range(20):
        tasks.add(0.005, code=3 if at == 4 else 0)
    driver = Driver(program, "slurm", tasks, "--partition=all", "--time=5", **sets_up(cluster))
    driver.all_done(60, {"slice-5": 3})
    expect(set(tasks.noted("ended").values()) == {1} and len(tasks.noted("ended")) == 20, f"not each once: {tasks.noted('ended')}")
    left = sorted(path.name for path in (tasks.folder / "engine").iterdir() if path.suffix in (".rc", ".tasks", ".new"))
    expect(not left, f"left in the folder: {left}")
    say(f"20 tasks of 5 ms, one of which fails: {1000 * (driver.taken - driver.ready) / 20:.0f} ms each; the failed one is a result and was done once")
    # What is over is no longer gone on with.
    driver = Driver(program, "slurm", tasks, "--partition=all", "--time=5", **sets_up(cluster))
    driver.all_done(60, {"slice-5": 3})
    expect(set(tasks.noted("ended").values()) == {2}, "a second call did not begin anew")


def driver_killed(program, folder, cluster):
    tasks = Tasks(folder, "driver")
    for _ in range(6):
        tasks.add(4)
    tasks.add(0.1, code=9)
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    driver.kill()
    other = Tasks(folder, "other").add(0.1)
    other.folder = tasks.folder
    stranger = Driver(program, "slurm", other, **sets_up(cluster))
    stranger.finish(20, 2)
    expect("other tasks of an earlier driver go on" in stranger.lines[-1], stranger.lines)
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    driver.all_done(60, {"slice-7": 9})
    expect(any("goes on with what an earlier driver submitted" in line for line in driver.lines), driver.lines)
    once = tasks.noted("begun")
    expect(set(once.values()) == {1} and len(once) == 7, f"not each once: {once}")
    say(f"the driver killed -9 and started again: it found its job, all was done once, over after {driver.taken:.1f} s; other tasks were refused meanwhile")
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    until(lambda: sum(tasks.noted("begun").values()) >= 9, 30, "two tasks begin")
    driver.kill()
    until(lambda: not queue(cluster, tasks), 60, "the job comes to its end without a driver")
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    driver.all_done(30, {"slice-7": 9})
    expect(set(tasks.noted("begun").values()) == {2}, f"not each once more: {tasks.noted('begun')}")
    say(f"the job had come to its end meanwhile: nothing was done again, over after {driver.taken:.1f} s")


def driver_killed_while_submitting(program, folder, cluster):
    """After the job is there, and before its number is noted."""
    real = shutil.which("sbatch", path=cluster.environment["PATH"])
    place, _ = stubs(folder, "slow", sbatch=f'said=$("{real}" "$@"); [ "$1" = --version ] || sleep 5; echo "$said"')
    for client in ("squeue", "scancel"):
        os.unlink(os.path.join(place, client))
    tasks = Tasks(folder, "submitting").add(2).add(2)
    environment = sets_up(cluster)
    driver = Driver(program, "slurm", tasks, **{**environment, "PATH": f"{place}:{environment['PATH']}"})
    until(lambda: tasks.noted("begun"), 30, "a task begins")
    driver.kill()
    driver = Driver(program, "slurm", tasks, **environment)
    driver.all_done(60)
    expect(set(tasks.noted("begun").values()) == {1}, f"begun: {tasks.noted('begun')}")
    say("the driver killed -9 before it knew the number of its job: the next one found it by its name")


def interrupted(program, folder, cluster):
    tasks = Tasks(folder, "interrupted")
    for _ in range(6):
        tasks.add(60)
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    begun = time.monotonic()
    driver.interrupt()
    driver.finish(60, 105)
    taken = time.monotonic() - begun
    expect(not [place for place, state in queue(cluster) if state != "CG"], f"in the queue: {queue(cluster)}")
    gone = until(lambda: not tasks.processes() and not queue(cluster), 30, "no task is left after Ctrl-C")
    say(f"Ctrl-C: no job is left after {taken:.1f} s, and no process {gone:.1f} s later")


def cancelled(program, folder, cluster):
    """A task that somebody else takes out of the queue has no exit code, and is submitted again after what a shared disk may take."""
    tasks = Tasks(folder, "cancelled").add(3).add(0.1)
    driver = Driver(program, "slurm", tasks, **sets_up(cluster), ENGINE_SETTLE="2")
    until(lambda: len(tasks.noted("begun")) >= 2, 30, "two tasks begin")
    running = next(place for place, state in queue(cluster, tasks) if state == "R")
    cluster.ask("scancel", running)
    driver.all_done(60)
    expect(any("submitted again" in line for line in driver.lines), driver.lines)
    expect(sum(tasks.noted("begun").values()) == 3, f"begun: {tasks.noted('begun')}")
    say("a task that was taken out of the queue is submitted again")


def begin_to_kill_a_node(program, folder, cluster):
    tasks = Tasks(folder, "node")
    for _ in range(4):
        tasks.add(12)
    tasks.add(0.1, code=7)
    driver = Driver(program, "slurm", tasks, **sets_up(cluster))
    until(lambda: len(tasks.noted("begun")) >= 4, 30, "four tasks begin")
    cluster.kill_node("two")
    until(lambda: len(tasks.processes()) <= 2, 5, "the tasks of the node are gone")
    return tasks, driver, time.monotonic()


def all_done_without_the_node(tasks, driver, killed):
    driver.all_done(240, {"slice-5": 7})
    begun, ended = tasks.noted("begun"), tasks.noted("ended")
    expect(sorted(begun.values()) == [1, 1, 1, 2, 2], f"begun: {begun}")
    expect(set(ended.values()) == {1} and len(ended) == 5, f"ended: {ended}")
    say(f"a node killed -9: nothing was lost, two tasks were done again, the failed one was not; over {time.monotonic() - killed:.0f} s after that")


def checks(program, folder, root):
    program, folder = os.path.abspath(program), os.path.abspath(folder)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    cluster = Cluster(root, os.path.join(folder, "cluster"))
    try:
        expect_loopback([daemon.pid for daemon in cluster.daemons.values()])
        say("a cluster of two nodes is there, on loopback alone")
        refused(program, folder, cluster)
        interrupted(program, folder, cluster)
        node = begin_to_kill_a_node(program, folder, cluster)
        # Slurm waits two minutes before it repeats what a node has lost. Meanwhile the other checks need no cluster, or have the other node.
        missing(program, folder)
        given_up(program, folder)
        silent(program, folder)
        done(program, folder, cluster)
        shares(folder, "slurm", "--slurm-option=--time=5", **sets_up(cluster))
        driver_killed_while_submitting(program, folder, cluster)
        driver_killed(program, folder, cluster)
        cancelled(program, folder, cluster)
        all_done_without_the_node(*node)
        # Slurm may still be completing what has just ended.
        until(lambda: not queue(cluster), 60, "nothing is left in the queue")
    finally:
        cluster.stop()
    expect(not cluster.left(), f"left: {cluster.left()}")


if __name__ == "__main__":
    main(checks)
