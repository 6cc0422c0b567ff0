"""These tests compare solve() with closed forms and with the program."""

import os
import signal
import subprocess
import tempfile
import unittest

import numpy

import viewpeel
from scenes import PLATE_POINTS, PLATES, PLATES_F, PROGRAM, scene_file

SIGMA = 5.670374419e-8


class Heat(unittest.TestCase):
    def test_two_black_plates_in_the_open(self):
        """Black plates have q_1 = s (T_1^4 - F T_2^4 - (1 - F) T_e^4). An error of F of 2e-7, 1e-6 of F, moves q_1 by
        less than 2e-7 s T_1^4.
        """
        materials = {"low": {"temperature": 400.0}, "high": {"temperature": 300.0}}
        heat = viewpeel.solve((PLATE_POINTS, PLATES, ["low", "high"]), materials, environment=250.0)
        expected = SIGMA * (400**4 - PLATES_F * 300**4 - (1 - PLATES_F) * 250**4)
        self.assertEqual(heat.name, ["low", "high"])
        self.assertLess(abs(heat.heat_flux[0] - expected), 2e-7 * SIGMA * 400**4)
        numpy.testing.assert_allclose(heat.heat_flow.sum(), heat.to_environment[0], rtol=1e-10)

    def test_the_program_gives_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs, checkpoint = (os.path.join(folder, name) for name in ("ours.csv", "theirs.csv", "run.ck"))
            materials = scene_file("office_materials.csv")
            result = viewpeel.compute(scene_file("office.obj"), by="surface", directions=32, resolution=64, checkpoint=checkpoint)
            viewpeel.solve(result, materials).save(ours)
            subprocess.run([PROGRAM, "solve", "--from-result", checkpoint, "--materials", materials, "--quiet", "-o", theirs,
                            scene_file("office.obj")], check=True)  # fmt: skip
            # Both solve the equations to 1e-11 of the largest radiosity less s T_0^4, which is below s 400^4 here. Two
            # such errors add up, and answers sum over radiosities: a hundred times as much is allowed.
            a, b = (numpy.genfromtxt(file, delimiter=",", skip_header=1)[:, 1:] for file in (ours, theirs))
            numpy.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * SIGMA * 400**4)

    def test_bounds_hold_the_answers(self):
        """Bounds of a guarantee hold the true answer, and so do 5 standard errors around an estimate: the two overlap.
        The seed is fixed. Negative control: twice the answer is outside the bounds of some row.
        """
        scene, materials = scene_file("office.obj"), scene_file("office_materials.csv")
        bounded = viewpeel.solve(scene, materials, epsilon=2e-2)
        estimate = viewpeel.solve(scene, materials, tolerance="0.5%")
        self.assertGreater(bounded.heat_flow_bounds.max(), 0)
        self.assertTrue((abs(bounded.heat_flow - estimate.heat_flow) <= bounded.heat_flow_bounds + 5 * estimate.heat_flow_standard_errors).all())
        self.assertFalse((abs(bounded.heat_flow - 2 * estimate.heat_flow) <= bounded.heat_flow_bounds).all())
        self.assertIn("temperature_bound", bounded.to_frame())
        self.assertIsNone(viewpeel.solve(viewpeel.compute(scene, by="surface", directions=16), materials).heat_flow_bounds)

    def test_a_tolerance_of_the_answers_is_reached(self):
        scene, materials = scene_file("office.obj"), scene_file("office_materials.csv")
        for text, column, limit in (("0.05K", "temperature", 0.05), ("0.5W/m2", "heat_flux", 0.5)):
            heat = viewpeel.solve(scene, materials, tolerance=text)
            self.assertLessEqual(getattr(heat, f"{column}_standard_errors").max(), limit)
        for text in ("0.1", "0.1C", "0K", "-1K", "K"):
            with self.assertRaisesRegex(ValueError, "tolerance"):
                viewpeel.solve(scene, materials, tolerance=text)
        with self.assertRaisesRegex(ValueError, "epsilon"):
            viewpeel.solve(scene, materials, tolerance="1%", epsilon=1e-2)
        with self.assertRaisesRegex(TypeError, "colour"):
            viewpeel.solve(scene, materials, tolerance="1%", colour=1)

    def test_ctrl_c_says_interrupted(self):
        """A run to a tolerance of the answers that Ctrl-C stops has no result. A run with another goal has the form
        factors that were counted so far.
        """

        def stop(progress):
            if progress["replicates"] >= wanted:
                os.kill(os.getpid(), signal.SIGINT)

        scene, materials = scene_file("office.obj"), scene_file("office_materials.csv")
        wanted = 0
        with self.assertRaises(viewpeel.Interrupted) as caught:
            viewpeel.solve(scene, materials, tolerance="1e-7K", progress=stop)
        self.assertIsNone(caught.exception.result)
        wanted = 3
        with self.assertRaises(viewpeel.Interrupted) as caught:
            viewpeel.solve(scene, materials, directions=256, resolution=256, replicates=2000, pair_lines=False, progress=stop)
        self.assertGreaterEqual(caught.exception.result.parameters["replicates"], 3)

    def test_surfaces_sum_up_polygons(self):
        heat = viewpeel.solve(scene_file("office.obj"), scene_file("office_materials.csv"), by="polygon", tolerance=2e-2)
        surfaces = heat.by_surface()
        self.assertEqual((len(heat), len(surfaces)), (576, 18))
        numpy.testing.assert_allclose(surfaces.heat_flow.sum(), heat.heat_flow.sum(), atol=1e-6)
        self.assertEqual(list(surfaces.to_frame()["name"]), surfaces.name)

    def test_bad_materials(self):
        plates = (PLATE_POINTS, PLATES, ["low", "high"])
        for materials, pattern in (
            ({"low": {"temperature": 300}}, "high"),
            ({"default": {"temperature": 300}, "attic": {"temperature": 300}}, "attic"),
            ({"default": {"temperature": 300, "heat_flux": 1}}, "one of temperature and heat_flux"),
            ({"default": {"temperature": 300, "emissivity": 1.5}}, "emissivity"),
            ({"default": {"temperature": -1}}, "temperature"),
            ({"default": {"colour": 1, "temperature": 300}}, "no 'colour'"),
            ({"default": {"temperature": 300}}, "environment"),
        ):
            with self.assertRaisesRegex(ValueError, pattern):
                viewpeel.solve(plates, materials)


if __name__ == "__main__":
    unittest.main()
