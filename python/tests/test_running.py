"""These tests watch, stop and continue runs, and run other threads meanwhile."""

import contextlib
import io
import os
import signal
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy

import viewpeel
from scenes import scene_file

# Each replicate takes some 0.1 s, and the whole run minutes.
LONG = dict(by="surface", directions=256, resolution=256, replicates=2000, pair_lines=False)


class StopAfter:
    """Sends Ctrl-C after this number of replicates."""

    def __init__(self, replicates):
        self.replicates, self.sent = replicates, False

    def __call__(self, progress):
        if progress["replicates"] >= self.replicates and not self.sent:
            self.sent = True
            os.kill(os.getpid(), signal.SIGINT)


class Running(unittest.TestCase):
    def test_ctrl_c_keeps_what_was_counted(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "office.ck")
            with self.assertRaises(viewpeel.Interrupted) as caught:
                viewpeel.compute(scene_file("office.obj"), checkpoint=file, progress=StopAfter(3), **LONG)
            stopped = caught.exception
            counted = stopped.result.parameters["replicates"]
            self.assertGreaterEqual(counted, 3)
            self.assertIsInstance(stopped, KeyboardInterrupt)
            self.assertEqual(stopped.checkpoint, file)
            # A run that is continued to more replicates has the bits of a run that never stopped.
            whole = dict(LONG, replicates=counted + 2)
            again = viewpeel.compute(scene_file("office.obj"), checkpoint=file, resume=True, **whole)
            at_once = viewpeel.compute(scene_file("office.obj"), **whole)
            numpy.testing.assert_array_equal(again.form_factors.toarray(), at_once.form_factors.toarray())
            self.assertEqual(again.parameters["replicates"], counted + 2)

    def test_a_checkpoint_is_not_overwritten(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "office.ck")
            open(file, "w").close()
            with self.assertRaisesRegex(ValueError, "is there already"):
                viewpeel.compute(scene_file("plates.obj"), checkpoint=file)
            with self.assertRaisesRegex(ValueError, "not a whole checkpoint"):
                viewpeel.compute(scene_file("plates.obj"), checkpoint=file, resume=True)

    def test_what_the_callback_raises_passes_on(self):
        class Enough(Exception):
            pass

        def stop(progress):
            raise Enough

        with self.assertRaises(Enough):
            viewpeel.compute(scene_file("office.obj"), progress=stop, **LONG)

    def test_other_threads_run_meanwhile(self):
        ticks, is_over = [], threading.Event()

        def count():
            while not is_over.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.01)

        other = threading.Thread(target=count)
        other.start()
        begun = time.monotonic()
        viewpeel.compute(scene_file("office.obj"), seconds=1.0, pair_lines=False)
        took = time.monotonic() - begun
        is_over.set()
        other.join()
        # If the run kept the interpreter's lock, the other thread would tick once or twice. It sleeps 0.01 s between
        # ticks, and so makes up to 100 a second; a tenth of that leaves room for a loaded machine.
        self.assertGreater(len(ticks), 10 * took)

    def test_two_runs_at_once_have_the_bits_of_one(self):
        options = dict(by="surface", directions=64, resolution=64)
        results = {}
        threads = [
            threading.Thread(target=lambda seed=seed: results.update({seed: viewpeel.compute(scene_file("office.obj"), seed=seed, **options)}))
            for seed in (1, 2)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for seed in (1, 2):
            alone = viewpeel.compute(scene_file("office.obj"), seed=seed, **options)
            numpy.testing.assert_array_equal(results[seed].form_factors.data, alone.form_factors.data)

    def test_progress_by_tqdm(self):
        def bar_of(**options):
            shown = io.StringIO()
            with contextlib.redirect_stderr(shown):
                viewpeel.compute(scene_file("office.obj"), by="surface", pair_lines=False, progress=True, **options)
            return shown.getvalue()

        self.assertRegex(bar_of(tolerance=3e-3, directions=32, promise=False), r"counting: [1-9][0-9]* replicates.*largest standard error [0-9.]+e-[0-9]+")
        self.assertRegex(bar_of(directions=256, resolution=256, replicates=8), r"counting: .* [1-7]/8 ")

    def test_progress_needs_tqdm(self):
        with unittest.mock.patch.dict("sys.modules", {"tqdm.auto": None}):
            with self.assertRaisesRegex(ValueError, "needs tqdm"):
                viewpeel.compute(scene_file("plates.obj"), progress=True)


if __name__ == "__main__":
    unittest.main()
