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

    def test_without_form_factors_the_program_gives_the_same(self):
        """The same seed gives the same bits, which a .csv keeps."""
        scene, materials = scene_file("office.obj"), scene_file("office_materials.csv")
        heat = viewpeel.solve(scene, materials, matrix_free=True, tolerance="2%")
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = os.path.join(folder, "ours.csv"), os.path.join(folder, "theirs.csv")
            heat.save(ours)
            subprocess.run([PROGRAM, "solve", scene, "--materials", materials, "--matrix-free", "on", "--tolerance", "2%", "--quiet",
                            "-o", theirs], check=True)  # fmt: skip
            with open(ours) as a, open(theirs) as b:
                self.assertEqual(a.read(), b.read())
        with self.assertRaisesRegex(ValueError, "no form factors were kept"):
            heat.form_factors
        with self.assertRaisesRegex(ValueError, "epsilon"):
            viewpeel.solve(scene, materials, matrix_free=True, epsilon=1e-2)
        with self.assertRaisesRegex(ValueError, "of form factors"):
            viewpeel.solve(scene, materials, matrix_free=True, tolerance=1e-2)

    def test_bands_and_directions(self):
        """With one emissivity in all bands answers are grey, within 5 standard errors. Negative control: emissivities
        that differ between bands change the heat. Plates that emit and absorb most along their normals exchange more
        than diffuse ones, for they face each other.
        """
        plates = (PLATE_POINTS, PLATES, ["low", "high"])
        grey = {"low": {"temperature": 600, "emissivity": 0.3}, "high": {"temperature": 300, "emissivity": 0.4}}
        truth = viewpeel.solve(plates, grey, environment=250)
        for matrix_free in (False, True):
            heat = viewpeel.solve(plates, grey, environment=250, bands=[4, 9], matrix_free=matrix_free)
            error = 5 * heat.heat_flow_standard_errors + 1e-9 * SIGMA * 600**4
            self.assertTrue((abs(heat.heat_flow - truth.heat_flow) <= error).all())
            other = dict(grey, low={"temperature": 600, "emissivity": [0.1, 0.3, 0.9]})
            self.assertGreater(abs(viewpeel.solve(plates, other, environment=250, bands=[4, 9], matrix_free=matrix_free).heat_flow - truth.heat_flow).max(), error.max())
        forward = {name: dict(material, directional=2) for name, material in grey.items()}
        table = {name: dict(material, directional=[(0, 1), (90, 1)]) for name, material in grey.items()}
        bent, flat = (viewpeel.solve(plates, materials, environment=250, tolerance="0.2%") for materials in (forward, table))
        self.assertLess(abs(flat.heat_flow - truth.heat_flow).max(), 5 * flat.heat_flow_standard_errors.max())
        self.assertGreater(flat.heat_flow[1] - bent.heat_flow[1], 5 * bent.heat_flow_standard_errors[1])

    def test_bad_materials(self):
        plates = (PLATE_POINTS, PLATES, ["low", "high"])
        for materials, pattern in (
            ({"low": {"temperature": 300}}, "high"),
            ({"default": {"temperature": 300}, "attic": {"temperature": 300}}, "attic"),
            ({"default": {"temperature": 300, "heat_flux": 1}}, "one of temperature and heat_flux"),
            ({"default": {"temperature": 300, "emissivity": 1.5}}, "emissivity"),
            ({"default": {"temperature": -1}}, "temperature"),
            ({"default": {"colour": 1, "temperature": 300}}, "no 'colour'"),
            ({"default": {"temperature": 300, "directional": "cosine"}}, "directional"),
            ({"default": {"temperature": 300, "emissivity": 0.9, "directional": 3}}, "emissivity"),
            ({"default": {"temperature": 300, "emissivity": [0.5, 0.6]}}, "2 emissivities for 1 band"),
            ({"default": {"temperature": 300}}, "environment"),
        ):
            with self.assertRaisesRegex(ValueError, pattern):
                viewpeel.solve(plates, materials)
        with self.assertRaisesRegex(ValueError, "bands"):
            viewpeel.solve(plates, {"default": {"temperature": 300}}, environment=250, bands=[4, 3])


if __name__ == "__main__":
    unittest.main()
