#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""panoptic batch --slurm on a real Slurm of one node in a folder of its own: Debian's munged, slurmctld and slurmd. Its maps are those of
panoptic batch --jobs, more scenes than an array may have become several arrays, and what was cancelled or killed goes on.

Usage: batch_slurm_test.py PROGRAM    with PANOPTIC_SCENES and PANOPTIC_FRAMES in the environment: so many homes of so many frames, and the times"""
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
SKIPPED = 77
RUN_OPTIONS = ["--no-pictures", "--set", "map.voxel_size_m=0.06", "--threads", "1"]
SCENES = int(os.environ.get("PANOPTIC_SCENES", 5))
FRAMES = int(os.environ.get("PANOPTIC_FRAMES", 6))
IS_MEASURED = "PANOPTIC_SCENES" in os.environ
MAX_ARRAY_SIZE = 1001 if IS_MEASURED else 3  # Slurm's default; so that five scenes are three arrays


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def configuration(folder, user):
    host = socket.gethostname().split(".")[0]
    return f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MaxArraySize={MAX_ARRAY_SIZE}
MpiDefault=none
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


class RealSlurm:
    """Daemons in the foreground, ended with the object."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = []
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "slurm.conf").write_text(configuration(folder, user))
        (folder / "cgroup.conf").write_text("CgroupPlugin=autodetect\n")
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"))
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket",
                   f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/munged.seed")
        self.wait(lambda: (folder / "munge.socket").exists(), "munged made no socket")
        self.start("slurmctld", "-D", "-i")
        self.start("slurmd", "-D")
        self.wait(lambda: "idle" in self.said("sinfo", "--noheader", "--format=%T"), "the node did not become idle")

    def start(self, program, *words):
        path = shutil.which(program) or f"/usr/sbin/{program}"
        with open(self.folder / f"{program}.out", "w", encoding="utf-8") as log:
            daemon = subprocess.Popen([path, *words], env=self.environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        self.daemons.append(daemon)

    def said(self, *command):
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True)
        return done.stdout + done.stderr

    def wait(self, condition, what, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                logs = "".join(p.read_text()[-2000:] for p in sorted(self.folder.glob("*.log")))
                raise RuntimeError(f"{what}\n{logs}")
            time.sleep(0.2)

    def wait_for_all_jobs(self):
        self.wait(lambda: self.said("squeue", "--noheader").strip() == "", "jobs did not end", 600)

    def end(self):
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()


class BatchOnSlurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="panoptic_slurm_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        (cls.root / "slurm").mkdir()
        cls.slurm = RealSlurm(cls.root / "slurm")
        cls.addClassCleanup(cls.slurm.end)
        cls.list = cls.root / "list.txt"
        cls.list.write_text("".join(f"sim:{seed},rooms=1,frames={FRAMES}\n" for seed in range(1, SCENES + 1)))
        cls.local = cls.root / "local"
        begin = time.monotonic()
        done = cls.batch(cls.local, "--jobs", "2")
        assert done.returncode == 0, done.stderr
        cls.tell_time("two at a time", cls.local, time.monotonic() - begin)

    @staticmethod
    def tell_time(name, out, wall_s):
        if IS_MEASURED:
            half_s = json.loads((out / "batch.json").read_text())["sum_s"] / 2
            print(f"{SCENES} homes of {FRAMES} frames, {name}: {wall_s:.1f} s, {wall_s / half_s:.3f} of half the sum of the scenes", flush=True)

    @classmethod
    def batch(cls, out, *options):
        return subprocess.run([PROGRAM, "batch", str(cls.list), "-o", str(out), *options, "--", *RUN_OPTIONS], cwd=cls.root,
                              env=cls.slurm.environment, capture_output=True, text=True)

    def expect_same_maps(self, out):
        report = json.loads((out / "batch.json").read_text())
        logs = "".join(p.read_text() for p in sorted((out / "slurm").glob("*.log")))
        self.assertTrue(report["complete"], logs)
        self.assertEqual(len(report["scenes"]), SCENES)
        for scene in report["scenes"]:
            name = scene["name"]
            for file in ("mesh.ply", "objects.json"):
                self.assertEqual((out / name / file).read_bytes(), (self.local / name / file).read_bytes(), name)
            ours = json.loads((self.local / name / "scene.json").read_text())
            self.assertEqual(scene["map_hash"], ours["map_hash"])

    def test_maps_are_those_of_one_machine(self):
        out = self.root / "out of arrays"  # scripts must quote it
        begin = time.monotonic()
        done = self.batch(out, "--slurm", "--jobs", "2", "--slurm-option=--cpus-per-task=1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{SCENES} of {SCENES} scenes submitted", done.stdout)
        if not IS_MEASURED:
            self.assertEqual(len((out / "slurm" / "jobs.txt").read_text().split()), 4, "three arrays and who gathers")
        refused = self.batch(out)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("is being made by Slurm's jobs", refused.stderr)
        self.slurm.wait_for_all_jobs()
        self.tell_time("by Slurm with two slots", out, time.monotonic() - begin)
        self.expect_same_maps(out)
        again = self.batch(out, "--slurm")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn(f"0 of {SCENES} scenes submitted", again.stdout)
        self.slurm.wait_for_all_jobs()
        self.expect_same_maps(out)

    def test_killed_trees_go_on(self):
        out = self.root / "killed"
        chance = random.Random()
        for _ in range(3):
            batch = subprocess.Popen([PROGRAM, "batch", str(self.list), "-o", str(out), "--jobs", "2", "--", *RUN_OPTIONS], cwd=self.root,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            time.sleep(chance.uniform(0.2, 1.2) * (FRAMES / 6))
            os.killpg(batch.pid, signal.SIGKILL)
            batch.wait()
        self.assertEqual(self.batch(out, "--jobs", "2").returncode, 0)
        self.expect_same_maps(out)

    def test_cancelled_tasks_are_told_and_go_on(self):
        out = self.root / "cancelled"
        self.assertEqual(self.batch(out, "--slurm").returncode, 0)
        jobs = (out / "slurm" / "jobs.txt").read_text().split()
        self.slurm.wait(lambda: any(out.glob("*/log.txt")), "nothing began")
        self.slurm.said("scancel", "--signal=KILL", "--full", *jobs[:-1])
        self.slurm.said("scancel", *jobs[:-1])
        self.slurm.wait_for_all_jobs()
        report = json.loads((out / "batch.json").read_text())
        self.assertFalse(report["complete"])
        self.assertGreater(report["waiting"], 0)
        self.assertEqual(self.batch(out, "--slurm").returncode, 0)
        self.slurm.wait_for_all_jobs()
        self.expect_same_maps(out)


def missing():
    places = os.environ.get("PATH", "") + ":/usr/sbin"
    return [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "squeue") if not shutil.which(name, path=places)]


if __name__ == "__main__":
    if missing():
        print(f"skipped: no {', '.join(missing())} here (Debian: slurmctld slurmd slurm-client munge)")
        sys.exit(SKIPPED)
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
