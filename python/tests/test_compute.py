"""These tests call compute() with scenes of every kind, with options, and with errors."""

import os
import subprocess
import tempfile
import unittest
import warnings
from pathlib import Path

import numpy

import viewpeel
from scenes import PLATE_POINTS, PLATES, PLATES_F, PROGRAM, scene_file


def expect_plates(test, result):
    """Checks a result against the closed form of two squares. A pair that nothing blocks has its unoccluded form factor,
    which docs/method.md, section 11, promises to 1e-6 of its value, 2e-7 here; half of that is allowed.
    """
    test.assertEqual(result.form_factors.shape, (2, 2))
    test.assertLess(abs(result.form_factors[0, 1] - PLATES_F), 1e-7)


class Scenes(unittest.TestCase):
    def test_the_wheel_is_what_is_tested(self):
        self.assertIn("site-packages", viewpeel.__file__)
        self.assertNotIn("/source/", viewpeel.__file__)

    def test_a_file_gives_the_numbers_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = os.path.join(folder, "ours.csv"), os.path.join(folder, "theirs.csv")
            viewpeel.compute(scene_file("office.obj"), by="surface", directions=16, resolution=64).save(ours)
            command = [PROGRAM, "compute", scene_file("office.obj"), "--by", "surface", "--directions", "16",
                       "--resolution", "64", "--quiet", "-o", theirs]  # fmt: skip
            subprocess.run(command, check=True)
            self.assertEqual(Path(ours).read_text(), Path(theirs).read_text())
            # Negative control: another seed gives other bytes.
            viewpeel.compute(scene_file("office.obj"), by="surface", directions=16, resolution=64, seed=2).save(ours)
            self.assertNotEqual(Path(ours).read_text(), Path(theirs).read_text())

    def test_arrays(self):
        expect_plates(self, viewpeel.compute((PLATE_POINTS, PLATES)))
        named = viewpeel.compute((PLATE_POINTS.tolist(), [list(p) for p in PLATES], ["low", "high"]))
        expect_plates(self, named)
        self.assertEqual(named.names, ["low", "high"])

    def test_several_files(self):
        with tempfile.TemporaryDirectory() as folder:
            corners = [[PLATE_POINTS[k] for k in plate] for plate in PLATES]
            files = [Path(folder, name) for name in ("low.obj", "high.obj")]
            for file, plate in zip(files, corners):
                file.write_text("".join("v {} {} {}\n".format(*point) for point in plate) + "f 1 2 3 4\n")
            for scene in (files, tuple(str(file) for file in files)):
                result = viewpeel.compute(scene)
                expect_plates(self, result)
                self.assertEqual(result.names, ["low", "high"])
            with self.assertRaisesRegex(ValueError, "low.obj: is named twice"):
                viewpeel.compute([files[0], files[0]])
            with self.assertRaisesRegex(ValueError, "is no scene"):
                viewpeel.compute([])

    def test_polygons_of_different_sizes(self):
        points = numpy.vstack([PLATE_POINTS, [[5, 5, 5], [6, 5, 5], [5, 6, 5]]])
        result = viewpeel.compute((points, [*PLATES.tolist(), [8, 9, 10]], ["low", "high", "triangle"]))
        self.assertEqual(result.names, ["low", "high", "triangle"])
        numpy.testing.assert_allclose(result.areas, [1, 1, 0.5], rtol=1e-14)

    def test_a_mesh_of_meshio(self):
        import meshio

        mesh = meshio.Mesh(PLATE_POINTS, [("quad", PLATES), ("line", [[0, 1]])], cell_sets={"low": [[0], []], "high": [[1], []]})
        result = viewpeel.compute(mesh)
        expect_plates(self, result)
        self.assertEqual(result.names, ["low", "high"])
        with self.assertRaisesRegex(ValueError, "no triangles"):
            viewpeel.compute(meshio.Mesh(PLATE_POINTS, [("line", [[0, 1]])]))

    def test_a_mesh_of_vtk(self):
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk

        mesh, points, cells, names = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkStringArray()
        points.SetData(numpy_to_vtk(PLATE_POINTS, deep=True))
        names.SetName("surface")
        for corners, name in zip(PLATES, ["low", "high"]):
            cells.InsertNextCell(4, [int(corner) for corner in corners])
            names.InsertNextValue(name)
        mesh.SetPoints(points), mesh.SetPolys(cells), mesh.GetCellData().AddArray(names)
        result = viewpeel.compute(mesh)
        expect_plates(self, result)
        self.assertEqual(result.names, ["low", "high"])

    def test_a_mesh_with_vertices_and_faces(self):
        """A mesh with the attributes of trimesh.Trimesh; Debian has no trimesh."""

        class Mesh:
            vertices = PLATE_POINTS
            faces = numpy.array([[0, 1, 2], [0, 2, 3], [4, 7, 6], [4, 6, 5]])

        result = viewpeel.compute(Mesh(), tolerance=1e-3)
        self.assertEqual(len(result), 4)
        below, above = result.exchange_areas[:2, 2:].sum(), result.areas[:2].sum()
        self.assertLess(abs(below / above - PLATES_F), 1e-7)


class Options(unittest.TestCase):
    def test_a_guarantee_has_bounds(self):
        result = viewpeel.compute(scene_file("past_edge.obj"), epsilon=0.05, delta=0.1)
        lower, upper = result.bounds
        self.assertTrue((lower.data <= result.form_factors.data).all() and (result.form_factors.data <= upper.data).all())
        self.assertTrue((upper.data - lower.data <= 0.1 + 1e-12).all())
        self.assertIsNone(viewpeel.compute(scene_file("plates.obj"), promise=False).bounds)

    def test_a_tolerance_is_promised_where_that_costs_little(self):
        result = viewpeel.compute(scene_file("street.obj"), tolerance=0.01)
        lower, upper = result.bounds
        self.assertEqual(result.parameters["epsilon"], 0.01)
        self.assertTrue((lower.data <= result.form_factors.data).all() and (result.form_factors.data <= upper.data).all())
        self.assertTrue((upper.data - lower.data <= 0.02 + 1e-12).all())
        self.assertIsNone(viewpeel.compute(scene_file("street.obj"), tolerance=0.01, replicates=8).bounds)

    def test_the_root_mean_square_of_all_errors(self):
        scene = scene_file("office.obj")
        fine = viewpeel.compute(scene, rms=2e-5)
        result = viewpeel.compute(scene, rms=2e-4, seed=2)
        n = result.form_factors.shape[0]
        of_all = [numpy.sqrt((errors**2).sum() / n**2) for errors in (
            result.form_factors.toarray() - fine.form_factors.toarray(), result.standard_errors.toarray())]  # fmt: skip
        self.assertLess(max(of_all), 2.2e-4)  # a tenth is for the error of the stated errors
        self.assertGreater(min(of_all), 0)
        with self.assertRaisesRegex(ValueError, "goal of its own"):
            viewpeel.compute(scene, rms=1e-4, tolerance=1e-3)

    def test_a_question(self):
        result = viewpeel.compute(scene_file("office.obj"), by="surface", rows_of="radiator", tolerance=1e-2)
        rows = numpy.unique(result.form_factors.tocoo().row)
        self.assertEqual([result.names[row] for row in rows], ["radiator"])

    def test_balanced_rows_sum_to_one(self):
        result = viewpeel.compute(scene_file("cube.obj"), balance=True)
        numpy.testing.assert_allclose(result.balanced.sum(axis=1), 1, rtol=0, atol=1e-12)
        self.assertIsNone(viewpeel.compute(scene_file("plates.obj")).balanced)

    def test_units_make_areas_metres(self):
        numpy.testing.assert_allclose(viewpeel.compute((PLATE_POINTS, PLATES), units="mm").areas, 1e-6, rtol=1e-12)

    def test_warnings_are_warnings(self):
        points = numpy.vstack([PLATE_POINTS, [[2, 2, 2]]])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = viewpeel.compute((points, [*PLATES.tolist(), [8, 8, 8]]))
        self.assertTrue(any("dropped" in str(warning.message) for warning in caught))
        self.assertEqual(result.areas[2], 0)
        self.assertEqual(len(result), 3)


class Errors(unittest.TestCase):
    def refuses(self, pattern, *arguments, **options):
        with self.assertRaisesRegex(ValueError, pattern) as caught:
            viewpeel.compute(*arguments, **options)
        self.assertNotIn("\n", str(caught.exception))

    def test_a_value_error_has_the_line_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "bad.obj")
            with open(file, "w") as out:
                out.write("v 0 0 0\nv 1 0 0\nf 1 2 9\n")
            told = subprocess.run([PROGRAM, "compute", file], capture_output=True, text=True)
            self.assertEqual(told.returncode, 2)
            with self.assertRaises(ValueError) as caught:
                viewpeel.compute(file)
            self.assertEqual(told.stderr, f"viewpeel: {caught.exception}\n")

    def test_bad_input(self):
        self.refuses("absent.obj", "absent.obj")
        self.refuses("corner 9 is not one of the 8 points", (PLATE_POINTS, [[0, 1, 9]]))
        self.refuses("corner -1", (PLATE_POINTS, [[0, 1, -1]]))
        self.refuses("finite", (PLATE_POINTS * numpy.nan, PLATES))
        self.refuses("two coordinates", (PLATE_POINTS[:, :2], PLATES))
        self.refuses("n x 3", (PLATE_POINTS.ravel(), PLATES))
        self.refuses("3 for 2 polygons", (PLATE_POINTS, PLATES, ["a", "b", "c"]))
        self.refuses("no scene", 7)
        self.refuses("whole numbers", (PLATE_POINTS, "abc"))
        for wrong in ([[0.5, 1, 2], [4, 6, 5]], numpy.array([[0.5, 1, 2], [4, 6, 5]]), [[numpy.nan, 1, 2], [4, 6, 5]]):
            self.refuses("an index of a point is not a whole number", (PLATE_POINTS, wrong))
        self.refuses("whole numbers", (PLATE_POINTS, [[0, 1, 2**70], [4, 6, 5]]))
        self.refuses("complex", (numpy.array(PLATE_POINTS) + 1j, [[0, 1, 2], [4, 6, 5]]))

    def test_bad_options(self):
        plates = scene_file("plates.obj")
        self.refuses("by: 'room' is not one of polygon, surface", plates, by="room")
        self.refuses("units", plates, units="yard")
        self.refuses("guarantee", plates, epsilon=0.1, tolerance=0.1)
        self.refuses("no surface or face is called 'attic'", plates, rows_of="attic")
        self.refuses("resume", plates, resume=True)
        for wrong in ({"tolerance": -1}, {"tolerance": float("nan")}, {"relative": 0}, {"epsilon": 2}, {"seconds": -1}):
            self.refuses("", plates, **wrong)
        with self.assertRaises(TypeError):
            viewpeel.compute(plates, tolerence=1e-3)
        self.refuses("epsilon: 'x' is not a number", plates, epsilon="x")
        self.refuses("directions: 1.5 is not a whole number from 0 to 4294967295", plates, directions=1.5)
        self.refuses("threads: -1 is not a whole number", plates, threads=-1)
        self.refuses("seed: -1 is not a whole number", plates, seed=-1)
        self.refuses("two_sided: 'yes' is not True or False", plates, two_sided="yes")


if __name__ == "__main__":
    unittest.main()
