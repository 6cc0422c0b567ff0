"""These tests look at a Result: matrices, arrays, tables, pictures, files."""

import base64
import copy
import json
import os
import pickle
import re
import tempfile
import unittest
import zlib

import numpy
import scipy.sparse

import viewpeel
from scenes import scene_file


class Results(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.result = viewpeel.compute(scene_file("office.obj"), by="surface", tolerance=1e-2)

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def test_matrices_are_sparse_and_have_one_pattern(self):
        result = self.result
        for matrix in (result.form_factors, result.standard_errors, result.exchange_areas):
            self.assertIsInstance(matrix, scipy.sparse.csr_array)
            self.assertEqual(matrix.shape, (18, 18))
            numpy.testing.assert_array_equal(matrix.indices, result.form_factors.indices)
            numpy.testing.assert_array_equal(matrix.indptr, result.form_factors.indptr)

    def test_matrices_share_the_library_s_memory(self):
        self.assertFalse(self.result.form_factors.data.flags.owndata)
        self.assertTrue(numpy.shares_memory(self.result.form_factors.indices, self.result.standard_errors.indices))

    def test_arrays_outlive_their_result(self):
        result = viewpeel.compute(scene_file("plates.obj"))
        data, before = result.form_factors.data, result.form_factors.data.copy()
        del result
        numpy.testing.assert_array_equal(data, before)

    # A file stores F, and a result stores A F. The way there and back rounds A F / A and F A, by 2^-53 of the value each.
    # Then A F is divided once more, and so was the A F of the first result: four roundings in all.
    def test_pickles_and_copies_are_results(self):
        for made in (pickle.loads(pickle.dumps(self.result)), copy.deepcopy(self.result)):
            self.assertEqual(made.names, self.result.names)
            numpy.testing.assert_allclose(made.form_factors.toarray(), self.result.form_factors.toarray(), rtol=2**-51)
            numpy.testing.assert_allclose(made.environment, self.result.environment, rtol=2**-51)
            self.assertEqual(made.bounds is None, self.result.bounds is None)

    def test_exchange_areas_are_symmetric_to_the_bit(self):
        areas = self.result.exchange_areas
        self.assertEqual(abs(areas - areas.T).max(), 0)
        expected = self.result.areas[:, None] * self.result.form_factors.toarray()
        numpy.testing.assert_allclose(areas.toarray(), expected, rtol=1e-15)

    def test_rows_add_up(self):
        result = self.result
        sums = result.form_factors.sum(axis=1) + result.environment + result.leak
        numpy.testing.assert_allclose(sums, result.row_sums, rtol=1e-12)
        self.assertEqual(result.closure.largest, abs(result.row_sums - 1).max())
        self.assertIn(result.closure.row, result.names)

    def test_every_format_is_written(self):
        for ending in ("csv", "mtx", "npz", "h5", "vtp", "vwf"):
            self.result.save(self.path("office." + ending))
            self.assertGreater(os.path.getsize(self.path("office." + ending)), 0)
        loaded = scipy.sparse.load_npz(self.path("office.npz"))
        self.assertEqual(abs(loaded - self.result.form_factors).max(), 0)
        with self.assertRaisesRegex(ValueError, "office.xls"):
            self.result.save(self.path("office.xls"))

    def test_a_file_that_cannot_be_written(self):
        with self.assertRaises((OSError, ValueError)):
            self.result.save(self.path("absent/office.csv"))

    def test_load_brings_back_what_was_saved(self):
        self.result.save(self.path("office.h5"))
        loaded = viewpeel.load(self.path("office.h5"))
        self.assertEqual(loaded.names, self.result.names)
        numpy.testing.assert_array_equal(loaded.areas, self.result.areas)
        for name in ("form_factors", "standard_errors"):
            ours, theirs = getattr(loaded, name), getattr(self.result, name)
            numpy.testing.assert_array_equal(ours.indices, theirs.indices)
            # A file stores F_ij. A loaded result multiplies it by A_i and divides again: two roundings, each of at most
            # 2^-53, and so a difference of at most two units in the last place.
            numpy.testing.assert_allclose(ours.data, theirs.data, rtol=4.5e-16)
        for name in ("environment", "leak", "environment_standard_errors", "leak_standard_errors", "row_sums"):
            numpy.testing.assert_allclose(getattr(loaded, name), getattr(self.result, name), rtol=4.5e-16)
        of_file = dict(loaded.parameters)
        self.assertEqual(of_file.pop("scene_file"), "office.obj")
        self.assertEqual(of_file, self.result.parameters)
        loaded.save(self.path("again.h5"))
        self.assertEqual(viewpeel.load(self.path("again.h5")).parameters, loaded.parameters)
        with self.assertRaisesRegex(ValueError, "vtp"):
            loaded.save(self.path("again.vtp"))

    def test_load_refuses_other_files(self):
        self.result.save(self.path("office.csv"))
        with self.assertRaisesRegex(ValueError, "not a whole result"):
            viewpeel.load(self.path("office.csv"))

    def test_the_frame_has_the_lines_of_the_csv(self):
        import pandas

        self.result.save(self.path("office.csv"))
        order = ["from", "to"]
        written = pandas.read_csv(self.path("office.csv"), float_precision="round_trip").sort_values(order)
        frame = self.result.to_frame().sort_values(order)
        pandas.testing.assert_frame_equal(frame.reset_index(drop=True), written.reset_index(drop=True), check_exact=True)

    def test_the_picture_shows_the_matrix(self):
        figure = self.result.plot()
        figure.savefig(self.path("office.png"))
        self.assertGreater(os.path.getsize(self.path("office.png")), 10_000)
        shown = figure.axes[0].images[0].get_array()
        dense = self.result.form_factors.toarray()
        numpy.testing.assert_array_equal(numpy.ma.filled(shown, 0), dense)

    def test_the_report_is_a_page_of_the_result(self):
        if os.environ.get("VIEWPEEL_PAGE") == "none":
            with self.assertRaisesRegex(ValueError, "built without the page"):
                self.result.report(self.path("office.html"))
            return
        self.result.report(self.path("office.html"))
        with open(self.path("office.html")) as file:
            page = file.read()
        head = json.loads(re.search(r'<script type="application/json" id="contents">(.*?)</script>', page, re.S).group(1))
        self.assertEqual(head["rows"], len(self.result))
        self.assertEqual(head["entries"], self.result.form_factors.nnz)
        self.assertTrue(head["has_scene"])
        # Each array's bytes are shuffled (all first bytes, then all second bytes, ...), deflated and written in base64.
        place = [part["name"] for part in head["arrays"]].index("form_factor.0")
        packed = re.search(f'id="block-{place}">(.*?)</script>', page).group(1)
        shuffled = numpy.frombuffer(zlib.decompress(base64.b64decode(packed)), dtype=numpy.uint8)
        values = numpy.ascontiguousarray(shuffled.reshape(8, -1).T).view("<f8").ravel()
        numpy.testing.assert_array_equal(values, self.result.form_factors.data)
        with self.assertRaisesRegex(ValueError, "ends in .html"):
            self.result.report(self.path("office.csv"))

    def test_the_table_of_a_notebook(self):
        text = self.result._repr_html_()
        place = self.result.form_factors.data.argmax()
        self.assertIn(f"{self.result.form_factors.data[place]:.6f}", text)
        self.assertEqual(text.count("<tr>"), 11)
        self.assertIn("18 rows", repr(self.result))


class Stubs(unittest.TestCase):
    def test_the_types_name_what_the_module_has(self):
        """Every name of _core.pyi is in the module, and the other way round."""
        import ast

        from viewpeel import _core

        with open(os.path.join(os.path.dirname(viewpeel.__file__), "_core.pyi")) as stubs:
            tree = ast.parse(stubs.read())
        of_types = {}
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                of_types[node.name] = {part.name for part in node.body if isinstance(part, ast.FunctionDef)} - {"__init__"}
            elif isinstance(node, ast.FunctionDef):
                of_types[node.name] = None
        of_module = {}
        for name, value in vars(_core).items():
            if name.startswith("_"):
                continue
            is_plain_class = isinstance(value, type) and not issubclass(value, BaseException)
            parts = {part for part in vars(value) if not part.startswith("_")} if is_plain_class else set()
            of_module[name] = parts if isinstance(value, type) else None
        self.assertEqual(of_types, of_module)

    def test_every_public_name_has_a_docstring(self):
        for name in viewpeel.__all__:
            value = getattr(viewpeel, name)
            if name in ("__version__", "Error"):
                continue
            self.assertTrue(value.__doc__, name)
            for part, member in vars(value).items() if isinstance(value, type) else ():
                if not part.startswith("_") and name != "Closure":
                    self.assertTrue(member.__doc__, f"{name}.{part}")


if __name__ == "__main__":
    unittest.main()
