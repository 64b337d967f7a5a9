#!/usr/bin/env python3
"""scripts/check_names.py on small trees."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).parents[2] / "scripts" / "check_names.py"


def check(files: dict) -> subprocess.CompletedProcess:
    """Runs the check on a tree of path -> text."""
    with tempfile.TemporaryDirectory() as root:
        for name, text in files.items():
            file = pathlib.Path(root) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return subprocess.run([sys.executable, CHECK, root], capture_output=True, text=True, check=False)


class CheckNames(unittest.TestCase):
    def test_one_definition_and_declarations_beside_it_pass(self):
        result = check(
            {
                "sim/types/pose.h": "struct Pose {\n};\n",
                "sim/truth/scene.h": "struct Pose;\nclass Scene final {\n  struct Pose {\n  };\n};\n",
            }
        )
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_type_defined_twice_is_named_with_both_files(self):
        for second in ("struct Line {\n", "class Line final : public Base {\n", "enum class Line { a };\n"):
            result = check({"sim/plant/line.h": "struct Line {\n};\n", "benchmarks/report/line.h": second})
            self.assertEqual(result.returncode, 1, second)
            self.assertIn("Line is defined in sim/plant/line.h and benchmarks/report/line.h", result.stdout)


if __name__ == "__main__":
    unittest.main()
