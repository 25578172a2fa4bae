"""Slurm on this machine: a controller and two nodes of one processor, all of the user's own."""
import getpass
import os
import shutil
import signal
import socket
import subprocess
import tempfile

from command_test import HANG_S, wait_until

CONFIGURATION = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock,cred_expire=5
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,bf_interval=1
ReturnToService=2
SlurmdTimeout=9
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1
PartitionName=all Nodes=ALL Default=YES State=UP
"""
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo")


def what_is_missing():
    """The reason why there can be no cluster, or nothing."""
    missing = [name for name in PROGRAMS if not shutil.which(name)]
    return f"no {', '.join(missing)} here: tools/install_packages slurm" if missing else ""


def free_ports(number):
    sockets = [socket.socket() for _ in range(number)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="slurm")
        self.environment = dict(os.environ, SLURM_CONF=self.folder + "/slurm.conf")
        os.mkdir(self.folder + "/state")
        with open(self.folder + "/slurm.conf", "w", encoding="utf-8") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname().split(".")[0], user=getpass.getuser(),
                                            folder=self.folder, ports=free_ports(3)))
        key = self.folder + "/munge.key"
        with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o400), "wb") as file:
            file.write(os.urandom(128))
        try:
            self.start_all(key)
        except BaseException:
            self.stop()
            raise

    def start_all(self, key):
        self.start("munged", "--force", f"--key-file={key}",
                   *(f"--{name}-file={self.folder}/munge.{name}" for name in ("pid", "log", "seed")),
                   f"--socket={self.folder}/munge.sock")
        self.start("slurmctld")
        for node in ("n1", "n2"):
            self.start("slurmd", "-N", node)
        wait_until(lambda: self.ask("sinfo", "-h", "-N", "-o", "%T").split() == ["idle", "idle"], 0.05)

    def start(self, *command):
        result = subprocess.run(command, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True,
                                text=True, check=False, timeout=HANG_S)
        assert result.returncode == 0, (command, result.stdout, result.stderr)

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False,
                              timeout=HANG_S).stdout

    def pid(self, name):
        with open(f"{self.folder}/{name}.pid", encoding="utf-8") as file:
            return int(file.read())

    def processes(self, **variables):
        """Processes of this cluster's jobs that have all of these variables, and raygrid's name."""
        wanted = {f"{name}={value}".encode() for name, value in variables.items()}
        wanted.add(f"SLURM_CONF={self.folder}/slurm.conf".encode())
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/environ", "rb") as file:
                    environment = set(file.read().split(b"\0"))
                with open(f"/proc/{pid}/comm", encoding="utf-8") as file:
                    is_raygrid = file.read().startswith("raygrid")
            except OSError:
                continue
            if is_raygrid and wanted <= environment:
                found.append((int(pid), environment))
        return found

    def stop(self):
        self.ask("scancel", "--user", getpass.getuser())
        for pid, _ in self.processes():
            os.kill(pid, signal.SIGKILL)
        for name in ("n1", "n2", "slurmctld", "munge"):
            try:
                pid = self.pid(name)
                os.kill(pid, signal.SIGTERM)
            except (OSError, ValueError):
                continue
            wait_until(lambda gone=f"/proc/{pid}": not os.path.exists(gone))
        shutil.rmtree(self.folder, ignore_errors=True)
