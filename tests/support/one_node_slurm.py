# SPDX-License-Identifier: Apache-2.0
"""A Slurm of this machine alone, in a temporary folder and on free ports, as the user who calls."""
import getpass
import os
import pathlib
import shutil
import socket
import subprocess
import time

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo"]


def find(program):
    return shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin:/usr/local/sbin")


def missing():
    """Which of its programs are not on this machine."""
    return [program for program in PROGRAMS if not find(program)]


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class OneNodeSlurm:
    """with OneNodeSlurm(folder, cpus) as slurm: run commands with slurm.environment. Stopped however that ends."""

    def __init__(self, folder, cpus=2):
        self.folder = pathlib.Path(folder)
        self.cpus = cpus
        self.processes = []
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"))

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        for name in ["munge", "state", "spool"]:
            (self.folder / name).mkdir(parents=True)
        munge = self.folder / "munge"
        munge.chmod(0o711)
        key = munge / "key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.launch("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge / 'socket'}",
                    f"--pid-file={munge / 'pid'}", f"--seed-file={munge / 'seed'}", f"--log-file={munge / 'log'}")
        self.wait_for(lambda: (munge / "socket").exists(), "munged")
        control, node = free_ports(2)
        host = socket.gethostname().split(".")[0]
        user = getpass.getuser()
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={munge / 'socket'}
CredType=cred/munge
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={self.folder / 'state'}
SlurmdSpoolDir={self.folder / 'spool'}
SlurmctldPidFile={self.folder / 'slurmctld.pid'}
SlurmdPidFile={self.folder / 'slurmd.pid'}
SlurmctldLogFile={self.folder / 'slurmctld.log'}
SlurmdLogFile={self.folder / 'slurmd.log'}
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=batch_sched_delay=0
MinJobAge=300
NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self.launch("slurmctld", "-D", "-f", str(self.folder / "slurm.conf"))
        self.launch("slurmd", "-D", "-N", host, "-f", str(self.folder / "slurm.conf"))
        self.wait_for(self.is_idle, "slurmctld and slurmd")

    def launch(self, program, *arguments):
        with open(self.folder / f"{program}.out", "w") as out:
            self.processes.append(subprocess.Popen([find(program), *arguments], stdout=out, stderr=out,
                                                   stdin=subprocess.DEVNULL, env=self.environment))

    def is_idle(self):
        told = subprocess.run([find("sinfo"), "-h", "-o", "%t"], env=self.environment, capture_output=True, text=True)
        return told.returncode == 0 and "idle" in told.stdout

    def wait_for(self, ready, what):
        end = time.monotonic() + 60
        while not ready():
            dead = [process.args[0] for process in self.processes if process.poll() is not None]
            if dead or time.monotonic() > end:
                logs = "".join(f"\n{log.name}:\n" + log.read_text(errors="replace")[-1500:]
                               for pattern in ["*.out", "*.log"] for log in self.folder.glob(pattern))
                raise RuntimeError(f"{what} did not come up{': ended: ' + ', '.join(dead) if dead else ''}{logs}")
            time.sleep(0.2)

    def stop(self):
        if len(self.processes) > 2:  # whatever is still at work
            subprocess.run([find("scancel"), "--user", getpass.getuser()], env=self.environment, capture_output=True)
            time.sleep(1)
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.processes = []
