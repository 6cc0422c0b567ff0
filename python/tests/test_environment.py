"""These tests measure the environment alone, its parts above and below the horizon, and bounds of the environment."""

import json
import os
import signal
import tempfile
import unittest
import warnings

import numpy

import viewpeel
from scenes import PLATES, PLATES_F, PLATE_POINTS, SOURCE, scene_file


class EnvironmentAlone(unittest.TestCase):
    def test_parallel_plates(self):
        found = viewpeel.environment((PLATE_POINTS, PLATES, ["floor", "ceiling"]), tolerance=3e-4)
        self.assertEqual(found.names, ["floor", "ceiling"])
        self.assertTrue(found.is_reached)
        # Errors of 8 replicates follow Student's t of 7 degrees of freedom, which exceeds 7 in size once in 4,700 cases.
        # The seed is fixed. Each plate sees the other, or else one half of the environment: up or down.
        for values, errors, truth in (
            (found.environment, found.environment_standard_errors, [1 - PLATES_F, 1 - PLATES_F]),
            (found.up, found.up_standard_errors, [1 - PLATES_F, 0]),
            (found.down, found.down_standard_errors, [0, 1 - PLATES_F]),
        ):
            self.assertLessEqual(errors.max(), 3e-4)
            self.assertTrue((abs(values - truth) <= 7 * errors).all())
            self.assertFalse((abs(values - numpy.array(truth) - 0.01) <= 7 * errors).all())  # negative control

    def test_another_way_up_and_surfaces(self):
        found = viewpeel.environment(scene_file("street.obj"), by="surface", up=(0, 2, 0), tolerance=1e-2, seed=3)
        self.assertEqual(len(found), 20)
        # The environment is counted as the sum of both parts, so that only rounding of numbers below 1 differs.
        numpy.testing.assert_allclose(found.up + found.down, found.environment, atol=1e-14)
        frame = found.to_frame()
        self.assertEqual(list(frame.columns)[:4], ["name", "area", "environment", "environment_standard_error"])
        self.assertEqual(list(frame["name"]), found.names)

    def test_time_limit_progress_and_errors(self):
        seen = []
        with self.assertWarnsRegex(UserWarning, "time was up"):
            found = viewpeel.environment(scene_file("street.obj"), tolerance=1e-7, seconds=0.5, progress=seen.append)
        self.assertFalse(found.is_reached)
        self.assertGreater(len(seen), 0)
        for options in (dict(by="desk"), dict(up=(0, 1)), dict(up=(0, 0, 0)), dict(tolerance=0.0), dict(zones="a")):
            with self.assertRaises(ValueError):
                viewpeel.environment((PLATE_POINTS, PLATES), **options)
        with self.assertRaises(TypeError):
            viewpeel.environment(scene_file("street.obj"), replicates=3)

    def test_ctrl_c(self):
        def stop(progress):
            os.kill(os.getpid(), signal.SIGINT)

        with self.assertRaises(viewpeel.Interrupted):
            viewpeel.environment(scene_file("street.obj"), tolerance=1e-6, progress=stop)


class CityModel(unittest.TestCase):
    """This test computes a city model of a roof at two levels of detail."""

    def test_lod(self):
        def roof(lod, corners):
            return {"type": "MultiSurface", "lod": lod, "boundaries": [[corners]]}

        model = {"type": "CityJSON", "version": "2.0", "transform": {"scale": [1, 1, 1], "translate": [0, 0, 0]}}
        model["vertices"] = [[0, 0, 5], [4, 0, 5], [4, 3, 5], [0, 3, 6]]
        model["CityObjects"] = {"b": {"type": "Building", "geometry": [roof("1.2", [0, 1, 2]), roof("2.2", [0, 1, 2, 3])]}}
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "a.city.json")
            with open(file, "w") as out:
                json.dump(model, out)
            self.assertAlmostEqual(viewpeel.compute(file, by="surface", lod=1.2).areas[0], 6)
            self.assertGreater(viewpeel.compute(file, by="surface").areas[0], 12)
            with self.assertRaisesRegex(ValueError, "give a larger --lod"):
                viewpeel.compute(file, lod=1)
        with self.assertRaisesRegex(ValueError, "lod: is of a city model"):
            viewpeel.compute(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), lod=1)


class Bounds(unittest.TestCase):
    def test_bounds_of_the_environment(self):
        result = viewpeel.compute(scene_file("street.obj"), by="surface", epsilon=2e-2, rows=True)
        lower, upper = result.environment_bounds
        self.assertTrue((lower <= result.environment).all() and (result.environment <= upper).all())
        self.assertTrue((upper - lower <= 4e-2).all() and (upper > lower).any())
        of_frame = result.to_frame()
        of_frame = of_frame[of_frame["to"] == "environment"]
        numpy.testing.assert_array_equal(of_frame["lower"], lower[result.environment > 0])
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "a.h5")
            result.save(file)
            numpy.testing.assert_allclose(viewpeel.load(file).environment_bounds, (lower, upper), rtol=1e-14)
        estimate = viewpeel.compute(scene_file("street.obj"), by="surface", tolerance=1e-2, promise=False)
        self.assertIsNone(estimate.environment_bounds)
        self.assertIsNone(estimate.leak_bounds)


class Buildings(unittest.TestCase):
    """These tests compute one zone of a building, and the building from outside, as the program does by --zone and
    --outside."""

    BUILDING = os.path.join(SOURCE, "tests", "fuzz", "seeds", "idf", "rooms.idf")

    def test_zones_and_outside(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # InternalMass has no geometry
            zone = viewpeel.compute(self.BUILDING, tolerance=1e-2, by="surface", zones="East")
            self.assertEqual(zone.names, ["East " + side for side in ("south", "east", "north", "west", "floor", "ceiling")])
            self.assertEqual(zone.environment.max(), 0)
            with self.assertRaisesRegex(ValueError, "no zone 'attic'"):
                viewpeel.compute(self.BUILDING, zones=["attic"])
            outside = viewpeel.compute(self.BUILDING, tolerance=1e-2, by="surface", outside=True)
            self.assertEqual(outside.environment[outside.names.index("East floor")], 1)


if __name__ == "__main__":
    unittest.main()
