# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""However a program ends, in the middle of work or as a copy of another process, it ends by itself and without a crash."""
import pathlib
import signal
import subprocess
import sys
import time
import unittest

from home import SOURCE, home, scratch, shared

HERE = pathlib.Path(__file__).resolve().parent

BEGIN = """
import os, sys, threading, time
import numpy as np
import panoptic as pf
from home import LABELS, arrays, ids_of, small_mapper

class Slow(pf.Predictor):
    def __init__(self):
        super().__init__(LABELS)
    def predict(self, frame):
        time.sleep(0.05)
        return pf.Segmentation(ids_of(), ["wall", "chair"], labels=self.labels)

def say(text):
    print(text, flush=True)

def in_child(work):
    child = os.fork()
    if child == 0:
        try:
            work()
        except BaseException as error:
            say(f"{type(error).__name__}: {error}")
        say("the child is through")
        sys.exit(0)
    for _ in range(200):
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return say(f"child: {status}")
        time.sleep(0.05)
    os.kill(child, 9)
    say("the child hangs")
"""


def start(script):
    places = f"HOME, SCRATCH = {str(home())!r}, {str(scratch())!r}\n"
    return subprocess.Popen([sys.executable, "-c", BEGIN + places + script], cwd=HERE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def run(script):
    """What the script prints; it has to end with 0 by itself."""
    process = start(script)
    out, err = process.communicate(timeout=60)
    if process.returncode != 0:
        raise AssertionError(f"exit status {process.returncode}\n{out}\n{err}")
    return out


class Exit(unittest.TestCase):
    def test_a_program_may_end_while_a_pipeline_is_at_work(self):
        run("""
pipeline = pf.OnlinePipeline(small_mapper(), Slow())
for i in range(8):
    pipeline.push(**arrays(i))
""")

    def test_a_program_may_end_while_its_threads_map(self):
        run("""
def add(mapper):
    while True:
        mapper.add(**arrays())

def push(pipeline):
    while True:
        pipeline.push_when_free(**arrays())

simulating = threading.Event()
def simulate():
    pf.simulate(SCRATCH + "/never", progress=lambda *_: simulating.set(), seed=3, rooms=1, frames=2000, noise="none")

threading.Thread(target=simulate, daemon=True).start()
simulating.wait()
for _ in range(3):
    threading.Thread(target=add, args=(small_mapper(),), daemon=True).start()
threading.Thread(target=push, args=(pf.OnlinePipeline(small_mapper(), Slow()),), daemon=True).start()
time.sleep(0.1)
""")
        self.assertEqual([p.name for p in scratch().iterdir() if p.name.startswith("never")], [])

    def test_a_predictor_may_drop_its_own_pipeline(self):
        out = run("""
pushed = threading.Event()
class Last(Slow):
    def predict(self, frame):
        global pipeline
        pushed.wait()
        try:
            pipeline.finish()
        except pf.Error as error:
            say(error)
        pipeline = None  # nobody has it any more
        return super().predict(frame)

mapper = small_mapper()
pipeline = pf.OnlinePipeline(mapper, Last())
pipeline.push(**arrays())
pushed.set()
while not mapper.finished:
    time.sleep(0.01)
say(mapper.frames["used"] > 0 and len(mapper.map_hash()))
pipeline = pf.OnlinePipeline(small_mapper(), Last())
pipeline.push(**arrays())
""")
        self.assertEqual(out.splitlines()[0], "a predictor cannot finish the pipeline that waits for it: call stop")
        self.assertEqual(out.splitlines()[1], "16")

    def test_a_program_may_end_while_threads_drop_their_pipelines(self):
        run("""
def work():
    while True:
        pipeline = pf.OnlinePipeline(small_mapper(), Slow())
        pipeline.push(**arrays())
        pipeline = None

for _ in range(3):
    threading.Thread(target=work, daemon=True).start()
time.sleep(0.3)
""")

    def test_a_program_that_fails_shows_its_own_error(self):
        process = start("""
pipeline = pf.OnlinePipeline(small_mapper(), Slow())
pipeline.push(**arrays())
raise KeyError("mine")
""")
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertEqual(err.strip().splitlines()[-1], "KeyError: 'mine'")


class Interrupt(unittest.TestCase):
    def interrupted(self, script):
        process = start(script)
        self.assertEqual(process.stdout.readline().strip(), "begun")
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        out, err = process.communicate(timeout=60)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(process.returncode, -signal.SIGINT, err)
        self.assertIn("KeyboardInterrupt", err)
        return out

    def test_mapping_ends_between_two_frames(self):
        out = self.interrupted("""
mapper = small_mapper()
say("begun")
try:
    while True:
        mapper.add(**arrays())
finally:
    say(f"a map of {mapper.frames['used'] > 0} frames, {len(mapper.map_hash())}")
""")
        self.assertIn("a map of True frames, 16", out)

    def test_an_online_run_ends(self):
        self.interrupted("""
pipeline = pf.OnlinePipeline(small_mapper(), Slow())
say("begun")
while True:
    pipeline.push_when_free(**arrays())
""")


class Fork(unittest.TestCase):
    """A child of fork has the memory of its parent, and none of its threads."""

    def test_a_child_may_map_and_read_after_its_parent_did(self):
        out = run("""
mapper, dataset = small_mapper(), pf.open_dataset(HOME)
for i in range(5):
    mapper.add(**arrays(i))
hashes = set()
def work():
    assert mapper.add(**arrays(5))
    own = small_mapper()
    for i in range(6):
        own.add(**arrays(i))
    assert own.map_hash() == mapper.map_hash()
    assert dataset[0].depth.shape == (480, 640)
in_child(work)
mapper.add(**arrays(6))
""")
        self.assertEqual(out.splitlines(), ["the child is through", "child: 0"])

    def test_a_child_cannot_use_the_pipeline_of_its_parent(self):
        out = run("""
mapper = small_mapper()
pipeline = pf.OnlinePipeline(mapper, Slow())
pipeline.push(**arrays())
def work():
    for use in (lambda: pipeline.push(**arrays()), lambda: pipeline.snapshot(), lambda: pipeline.finish(), lambda: mapper.mesh()):
        try:
            use()
            say("used")
        except pf.Error as error:
            assert "process" in str(error) or "in use" in str(error), error
in_child(work)
print(pipeline.finish()["used"])
""")
        self.assertEqual(out.splitlines(), ["the child is through", "child: 0", "1"])

    def test_workers_of_multiprocessing_map(self):
        out = run("""
import multiprocessing
def work(i):
    mapper = small_mapper()
    for j in range(3):
        mapper.add(segments=(ids_of(), ["wall", "chair"]), **arrays(j))
    return mapper.map_hash()
pf.set_threads(4)
expected = work(0)
def threads(count):
    try:
        pf.set_threads(count)
        return pf.threads()
    except pf.Error as error:
        return str(error)
stop = threading.Event()
def map_meanwhile():
    while not stop.is_set():
        work(0)
busy = threading.Thread(target=map_meanwhile)
busy.start()
with multiprocessing.get_context("fork").Pool(3) as pool:
    assert set(pool.map_async(work, range(6)).get(timeout=30)) == {expected}
    assert set(pool.map_async(threads, [0, 1]).get(timeout=30)) == {1}
    (refused,) = pool.map_async(threads, [2]).get(timeout=30)
    say(refused)
    assert set(pool.map_async(work, range(6)).get(timeout=30)) == {expected}
stop.set()
busy.join()
in_child(lambda: (pf.set_threads(0), work(0)))
assert pf.threads() == 4 and work(0) == expected
""")
        self.assertRegex(out, "child of os.fork.*spawn")
        self.assertEqual(out.splitlines()[1:], ["the child is through", "child: 0"])

    def test_a_child_reads_predictions_and_may_not_use_networks_of_its_parent(self):
        network = SOURCE / "configs/models/enet_scannet_nyu40.toml"
        shared("models/enet_scannet_nyu40")
        out = run(f"NETWORK = {str(network)!r}" + """
files, frame = pf.file_predictor(HOME + "/predictions"), pf.open_dataset(HOME)[3]
networks = pf.make_predictor(pf.Options(networks={"semantic": NETWORK}))
expected = files.predict(frame), networks.predict(frame)
def work():
    assert files.predict(frame) == expected[0]
    try:
        networks.predict(frame)
    except pf.Error as error:
        say(error)
in_child(work)
assert networks.predict(frame) == expected[1]
""")
        self.assertRegex(out.splitlines()[0], "made in the parent of this process")
        self.assertEqual(out.splitlines()[1:], ["the child is through", "child: 0"])

    def test_a_child_cannot_go_on_reading_where_its_parent_was(self):
        out = run("""
frames = iter(pf.open_dataset(HOME))
next(frames)
def work():
    global frames
    try:
        next(frames)
        say("read")
    except pf.Error as error:
        assert "process" in str(error), error
    del frames
in_child(work)
print(len(list(frames)))
""")
        self.assertEqual(out.splitlines(), ["the child is through", "child: 0", "7"])


if __name__ == "__main__":
    unittest.main()
