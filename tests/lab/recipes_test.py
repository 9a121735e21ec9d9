"""The recipes of docs/fleet.md for sweeps, as they are there but for the number of contacts: xargs, GNU parallel, and an array of jobs of
Slurm on a cluster of this one computer. Each merges to what one run prints, times aside. Skips what is not installed."""
import getpass, json, os, re, shutil, socket, subprocess, tempfile, unittest

from awaiting import PATIENCE_S, await_true
from ports import free_port

BUILD, SOURCE = os.environ["SLIPD_BINARY_DIR"], os.environ["SLIPD_SOURCE_DIR"]
PATH = os.path.join(BUILD, "bin") + ":" + os.environ["PATH"] + ":/usr/sbin"
CLUSTER = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo")
PLENTY = {"--contacts 20000": "--contacts 20 --layouts 8 4 --no-models", "--grasps 1000": "--grasps 10"}  # of the page, and what is enough here
TIMES = re.compile(r"_(us|ms|s)$|^front$")  # and what compares them


def has(*programs):
    return all(shutil.which(program, path=PATH) for program in programs)


def recipes():
    """The page's blocks of shell text about sweeps, made short."""
    with open(os.path.join(SOURCE, "docs", "fleet.md")) as file:
        page = file.read().partition("## Sweeps")[2]
    blocks = re.findall(r"^```sh\n(.*?)^```", page, re.S | re.M)
    for long, short in PLENTY.items():
        blocks = [block.replace(long, short) for block in blocks]
    return blocks


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(each) for key, each in value.items() if not TIMES.search(key)}
    return [without_times(each) for each in value] if isinstance(value, list) else value


class Cluster:
    """munged, slurmctld and slurmd of this computer, with their files in `folder`."""

    def __init__(self, folder, test):
        self.folder, host = folder, socket.gethostname().split(".")[0]
        path = lambda name: os.path.join(folder, name)
        self.environment = os.environ | {"PATH": PATH, "SLURM_CONF": path("slurm.conf")}
        with open(path("munge.key"), "wb", opener=lambda name, flags: os.open(name, flags, 0o600)) as key:
            key.write(os.urandom(128))
        for name in "state", "spool":
            os.mkdir(path(name))
        with open(path("cgroup.conf"), "w") as file:
            file.write("CgroupAutomount=no\n")
        user = getpass.getuser()
        with open(path("slurm.conf"), "w") as file:
            file.write(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={path("munge.socket")}
StateSaveLocation={path("state")}
SlurmdSpoolDir={path("spool")}
SlurmctldPidFile={path("slurmctld.pid")}
SlurmdPidFile={path("slurmd.pid")}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        munge = ["munged", "--foreground", "--force", "--key-file", path("munge.key"), "--socket", path("munge.socket"), "--pid-file", path("munge.pid"),
                 "--log-file", path("munge.log"), "--seed-file", path("munge.seed")]
        for command, ready in ((munge, lambda: os.path.exists(path("munge.socket"))), (["slurmctld", "-D"], lambda: self.run("sinfo", "-h").returncode == 0),
                               (["slurmd", "-D"], lambda: "idle" in self.run("sinfo", "-h", "-o", "%T").stdout)):
            with open(path(command[0] + ".out"), "w") as log:
                program = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
            test.addCleanup(lambda program=program: (program.terminate(), program.wait(PATIENCE_S)))
            await_true(lambda: ready() or program.poll() is not None, command[0])
            if program.poll() is not None:
                with open(path(command[0] + ".out")) as log:
                    test.fail(f"{command[0]} has ended: {log.read()}")

    def run(self, *command, **options):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=PATIENCE_S, **options)


class Recipes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def shell(self, text):
        ran = subprocess.run(["sh", "-ec", text], cwd=self.folder, env=os.environ | {"PATH": PATH}, capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(ran.returncode, 0, text + ran.stderr)
        return ran.stdout

    def recipe(self, word):
        found = [each for each in recipes() if word in each]
        self.assertEqual(len(found), 1, f"recipes of docs/fleet.md with {word}")
        return found[0]

    def assert_merged(self, merged, sweep):
        """`merged`: JSON text. `sweep`: the recipe's command with its options."""
        command = re.search(r"slipd-lab (.*?) --shard", sweep)[1]
        self.assertEqual(without_times(json.loads(merged)), without_times(json.loads(self.shell("slipd-lab --json " + command))))

    def test_processes_of_one_computer(self):
        recipe = self.recipe("xargs")
        self.shell(recipe)
        with open(os.path.join(self.folder, "histories.json")) as file:
            self.assert_merged(file.read(), recipe)

    @unittest.skipUnless(has("parallel"), "GNU parallel is not installed: run tools/setup --peers")
    def test_gnu_parallel(self):
        recipe = self.recipe("| parallel")
        self.shell(recipe)
        with open(os.path.join(self.folder, "histories.json")) as file:
            self.assert_merged(file.read(), recipe)

    @unittest.skipUnless(has(*CLUSTER), "Slurm is not installed: run tools/setup --peers")
    def test_an_array_of_jobs_of_slurm(self):
        recipe = self.recipe("SLURM_ARRAY_TASK_ID")
        cluster = Cluster(self.folder, self)
        jobs = os.path.join(self.folder, "jobs")
        os.mkdir(jobs)
        with open(os.path.join(jobs, "sweep.sh"), "w") as file:
            file.write(recipe)
        ran = cluster.run("sbatch", "--wait", "--array=1-4", "sweep.sh", cwd=jobs)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assert_merged(self.shell("slipd-lab merge jobs/part*.json"), recipe)


if __name__ == "__main__":
    unittest.main(warnings="ignore")
