#!/usr/bin/env python3
"""Runs a command with a Slurm cluster on this machine: munge, slurmctld and several slurmd.

usage: slurm_bed.py [--nodes N] [--cpus N] [--keep] -- COMMAND...

Everything lies in a temporary folder: keys, sockets, configuration, logs. The command finds the cluster through SLURM_CONF.
However this ends, no process of the cluster is left. Exit code: the command's; 1 where the cluster does not come up.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PACKAGES = "munge slurmctld slurmd slurm-client"
# Environment variable of a node's slurmd and its steps; their jobs have Slurm's own
# SLURMD_NODENAME.
NODE_MARK = "KINDLING_SLURM_BED_NODE"

# Times in seconds. A requeued job waits for cred_expire (two minutes by default, at least 5);
# a node is lost after SlurmdTimeout.
CONFIGURATION = """\
ClusterName=bed
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldDebug=info
SlurmdDebug=info
# Any number of processors, whatever the machine has; no cgroups, which containers cannot change.
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0,sched_min_interval=0
JobRequeue=1
ReturnToService=2
SlurmdTimeout=6
SlurmctldTimeout=10
MessageTimeout=5
BatchStartTimeout=10
UnkillableStepTimeout=30
KillWait=5
CompleteWait=0
InactiveLimit=0
TreeWidth=65533
{nodes}
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class BedError(Exception):
    pass


def free_ports(count):
    """Ports that are free now."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for item in sockets:
            item.bind(("127.0.0.1", 0))
        return [item.getsockname()[1] for item in sockets]
    finally:
        for item in sockets:
            item.close()


def processes_with(name, value):
    """Process ids whose environment has name=value."""
    wanted = f"{name}={value}".encode()
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            if wanted in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
        except OSError:
            continue  # ended meanwhile
    return found


def kill_all(pids):
    for pid in pids:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


class SlurmBed:
    """A running cluster: `with SlurmBed(nodes=3, cpus=1) as bed:` starts it; bed.environment is for its clients."""

    def __init__(self, nodes=3, cpus=1, folder=None, keep=False):
        self.node_names = [f"node{i + 1}" for i in range(nodes)]
        self.cpus = cpus
        self.keep = keep
        self.folder = Path(folder or tempfile.mkdtemp(prefix="kindling-slurm-"))
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith(("SLURM", "SBATCH", "SQUEUE"))}
        # Inherited by all processes of the cluster, those of jobs included, and so identifies
        # leftovers.
        self.environment["SLURM_CONF"] = str(self.folder / "slurm.conf")
        self.daemons = {}

    def __enter__(self):
        try:
            self._start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    # Nodes.

    def start_node(self, name):
        self._spawn(name, ["slurmd", "-D", "-N", name], {NODE_MARK: name})

    def kill_node(self, name):
        """Kills slurmd, its steps and their processes with SIGKILL, like a power cut. Returns the number of processes."""
        # slurmd first, so that it cannot report the end of the others.
        daemon = self.daemons.pop(name)
        daemon.kill()
        daemon.wait()
        killed = set()
        while pids := set(self.processes_of(name)) - killed:
            kill_all(pids)
            killed |= pids
        return len(killed) + 1

    def processes_of(self, name):
        """Processes of steps and jobs on a node."""
        mine = set(self.processes())
        return [pid for pid in processes_with(NODE_MARK, name) + processes_with("SLURMD_NODENAME", name) if pid in mine]

    def processes(self):
        """All processes of the cluster: daemons, steps, jobs and their children."""
        return processes_with("SLURM_CONF", self.environment["SLURM_CONF"])

    # Commands.

    def run(self, *command, check=True, **more):
        """Runs a client command of the cluster and returns its standard output."""
        result = subprocess.run([str(item) for item in command], env=self.environment, capture_output=True, text=True, stdin=subprocess.DEVNULL,
                                timeout=60, check=False, **more)
        if check and result.returncode != 0:
            raise BedError(f"{' '.join(map(str, command))}: exit code {result.returncode}: {result.stderr.strip()}")
        return result.stdout

    def wait_until(self, what, condition, seconds, every=0.2):
        """Waits until condition() is true and returns its value; BedError after a timeout."""
        end = time.monotonic() + seconds
        while True:
            value = condition()
            if value:
                return value
            if time.monotonic() > end:
                raise BedError(f"{what}: not within {seconds} s; {self.describe()}")
            for name, daemon in self.daemons.items():
                if daemon.poll() is not None:
                    raise BedError(f"{name} ended with exit code {daemon.returncode}; {self.describe()}")
            time.sleep(every)

    def node_states(self):
        lines = self.run("sinfo", "-h", "-N", "-o", "%N %T", check=False).splitlines()
        return dict(line.split()[:2] for line in lines)

    def describe(self):
        """The state of everything, for messages."""
        text = [f"nodes {self.node_states()}", self.run("squeue", "-a", "-r", "-o", "%i %T %r %N", check=False).strip()]
        for log in sorted(self.folder.glob("*.out.log")):
            text.append(f"--- {log.name}\n" + "\n".join(log.read_text(errors="replace").splitlines()[-15:]))
        return "\n".join(text)

    # Beginning and end.

    def _start(self):
        for program in ("munged", "slurmctld", "slurmd", "sbatch"):
            if not shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin"):
                raise BedError(f"there is no {program} here; Debian's packages are: {PACKAGES}")
        for name in ("munge", "state", *(f"spool-{node}" for node in self.node_names)):
            (self.folder / name).mkdir(mode=0o755)
        self.folder.chmod(0o755)  # clients of munge under any user need access to its socket
        ports = free_ports(len(self.node_names) + 1)
        host = socket.gethostname().split(".")[0]
        nodes = "\n".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={self.cpus} RealMemory=1000000 State=UNKNOWN"
                          for name, port in zip(self.node_names, ports[1:]))
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=host, user=pwd.getpwuid(os.geteuid()).pw_name, folder=self.folder, controller_port=ports[0], nodes=nodes))
        (self.folder / "cgroup.conf").write_text(f"CgroupPlugin=cgroup/v1\nCgroupMountpoint={self.folder}/cgroup\n")
        munge = self.folder / "munge"
        (munge / "key").write_bytes(os.urandom(128))
        (munge / "key").chmod(0o400)
        self._spawn("munged", ["munged", "--foreground", "--force", f"--socket={munge}/socket", f"--key-file={munge}/key",
                               f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed"])
        self.wait_until("munged's socket", (munge / "socket").exists, 10)
        self._spawn("slurmctld", ["slurmctld", "-D", "-c"])
        for name in self.node_names:
            self.start_node(name)
        self.wait_until("all nodes idle", lambda: list(self.node_states().values()).count("idle") == len(self.node_names), 60)

    def _spawn(self, name, command, more_environment=None):
        # Sessions of their own: Ctrl-C reaches this process alone, which then ends them.
        sbin = {"PATH": self.environment.get("PATH", "") + ":/usr/sbin:/sbin"}
        with open(self.folder / f"{name}.out.log", "ab") as log:
            self.daemons[name] = subprocess.Popen(command, env=self.environment | sbin | (more_environment or {}), stdin=subprocess.DEVNULL,
                                                  stdout=log, stderr=log, start_new_session=True, cwd=self.folder)

    def stop(self):
        for daemon in self.daemons.values():
            daemon.kill()
        for daemon in self.daemons.values():
            daemon.wait()
        self.daemons.clear()
        while pids := self.processes():
            kill_all(pids)
            time.sleep(0.05)
        if not self.keep:
            shutil.rmtree(self.folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=3, help="(3)")
    parser.add_argument("--cpus", type=int, default=1, help="of each node, whatever the machine has (1)")
    parser.add_argument("--keep", action="store_true", help="leave the folder with its logs")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    command = options.command[1:] if options.command[:1] == ["--"] else options.command
    if not command:
        parser.error("which COMMAND?")
    # SIGTERM tears the cluster down as SIGINT does.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        with SlurmBed(options.nodes, options.cpus, keep=options.keep) as bed:
            if options.keep:
                print(f"slurm_bed.py: {bed.folder}", file=sys.stderr)
            return subprocess.run(command, env=bed.environment, check=False).returncode
    except BedError as error:
        print(f"slurm_bed.py: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
