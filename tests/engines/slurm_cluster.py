"""A cluster of Slurm on this host's loopback: one controller, two nodes, a munge of its own. Everything of it is below one folder."""

import os
import pathlib
import pwd
import secrets
import socket
import subprocess
import tempfile
import time

from driver import environment, kill, parent, there

CONFIGURATION = """ClusterName=judge
SlurmctldHost=localhost(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={sockets}/munge.socket
# Otherwise both would listen on all addresses.
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmctldPort={ports[0]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
PluginDir={plugins}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=5
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
# A node that is gone is noticed sooner than after five minutes, and what is cancelled has less time to go.
SlurmdTimeout=10
KillWait=2
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=one NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[1]} CPUs=2
NodeName=two NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[2]} CPUs=2
PartitionName=all Nodes=one,two Default=YES
"""


class Cluster:
    """Started when it is made."""

    def __init__(self, root, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True)
        # The path of a socket has at most 107 bytes, and everybody may reach that of munge.
        self.sockets = pathlib.Path(tempfile.mkdtemp(prefix="slurm-judge-"))
        self.sockets.chmod(0o755)
        root = pathlib.Path(root)
        libraries = root / "usr/lib" / f"{os.uname().machine}-linux-gnu"
        plugins = libraries / "slurm-wlm"
        self.stepd = root / "usr/sbin/slurmstepd-wlm"
        self.environment = {
            **os.environ,
            "LD_LIBRARY_PATH": f"{libraries}:{plugins}",
            "PATH": f"{root / 'usr/bin'}:{root / 'usr/sbin'}:{os.environ['PATH']}",
            "SLURM_CONF": str(self.folder / "slurm.conf"),
        }
        (self.folder / "state").mkdir()
        user = pwd.getpwuid(os.getuid()).pw_name
        text = CONFIGURATION.format(user=user, sockets=self.sockets, ports=free_ports(3), folder=self.folder, plugins=plugins)
        (self.folder / "slurm.conf").write_text(text)
        self.daemons = {}
        try:
            self._start()
        except BaseException:
            self.stop()
            raise

    def _start(self):
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        of = lambda name: f"{self.folder / 'munge'}.{name}"
        socket_ = self.sockets / "munge.socket"
        self._daemon("munge", "munged", "--foreground", "--force", f"--key-file={key}", f"--socket={socket_}", f"--pid-file={of('pid')}", f"--seed-file={of('seed')}", f"--log-file={of('log')}")
        self._wait(socket_.exists, 10, "munge")
        self._daemon("controller", "slurmctld-wlm", "-D")
        for node in ("one", "two"):
            self.start_node(node)
        self._wait(lambda: self.ask("sinfo", "-h", "-N", "-o", "%N %t").split() == ["one", "idle", "two", "idle"], 30, "both nodes are idle")

    def start_node(self, node):
        (self.folder / node).mkdir(exist_ok=True)
        self._daemon(node, "slurmd-wlm", "-D", "-N", node, "-d", str(self.stepd))

    def kill_node(self, node):
        """As when the machine is switched off: its daemon and all that it has started."""
        steps = [one for one in there() if environment(one).get("SLURMD_NODENAME") == node]
        # A step's own process has no such word; it is what started them.
        parents = {parent(one) for one in steps}
        daemon = self.daemons.pop(node)
        daemon.kill()
        daemon.wait()
        kill(*[one for one in sorted(parents | set(steps)) if one > 1])

    def ask(self, *command):
        said = subprocess.run(command, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=30, check=False)
        return said.stdout + said.stderr

    def left(self):
        """Processes that belong to it and are there."""
        mark = str(self.folder)
        return [one for one in there() if environment(one).get("SLURM_CONF", "").startswith(mark)]

    def stop(self):
        for daemon in self.daemons.values():
            daemon.terminate()
        for daemon in self.daemons.values():
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons = {}
        for one in self.left():
            kill(one)
        for path in self.sockets.iterdir():
            path.unlink()
        self.sockets.rmdir()

    def _daemon(self, name, *command):
        with open(self.folder / "daemons", "ab") as said:
            self.daemons[name] = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True)

    def _wait(self, holds, seconds, what):
        begun = time.monotonic()
        while not holds():
            gone = [name for name, daemon in self.daemons.items() if daemon.poll() is not None]
            if gone or time.monotonic() - begun > seconds:
                said = (self.folder / "daemons").read_text(errors="replace")[-2000:]
                raise AssertionError(f"not within {seconds} s: {what}; ended: {gone}\n{said}")
            time.sleep(0.1)


def free_ports(count):
    """Ports that nobody has now."""
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports
