"""Programs that use viewpeel are checked by Debian's mypy."""

import os
import subprocess
import sys
import tempfile
import unittest

RIGHT = """
import viewpeel

result: viewpeel.Result = viewpeel.compute("office.obj", by="surface", tolerance=1e-3, sheets=["door"])
names: list[str] = result.names
total: float = float(result.areas.sum())
heat: viewpeel.Heat = viewpeel.solve(result, {"default": {"temperature": 300.0}})
sky: viewpeel.Environment = viewpeel.environment("street.obj", up=(0, 0, 1))
viewpeel.load("office.h5").save("office.csv")
"""
WRONG = """
import viewpeel

result = viewpeel.compute("office.obj", tolerance="fine")
names: int = result.names
result.form_factor
"""


class Types(unittest.TestCase):
    def check(self, program):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "program.py"), "w") as out:
                out.write(program)
            command = ["/usr/bin/mypy", "--strict", "--python-executable", sys.executable, "program.py"]
            run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        return [line for line in run.stdout.splitlines() if ": error: " in line], run.stdout + run.stderr

    def test_a_right_program_is_accepted(self):
        errors, told = self.check(RIGHT)
        self.assertEqual(errors, [])
        self.assertIn("Success", told)

    def test_each_error_is_found(self):
        errors, told = self.check(WRONG)
        self.assertEqual([line.split(":")[1] for line in errors], ["4", "5", "6"], told)


if __name__ == "__main__":
    unittest.main()
