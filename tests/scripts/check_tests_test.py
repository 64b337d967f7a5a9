#!/usr/bin/env python3
"""scripts/check_tests.py on small trees."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).parents[2] / "scripts" / "check_tests.py"
MIRROR = {
    "sim/types/pose.h": "",
    "tests/CMakeLists.txt": "",
    "tests/places/CMakeLists.txt": "",
    "tests/fuzz/CMakeLists.txt": "",
    "tests/sim/types/CMakeLists.txt": "",
    "tests/sim/types/pose_test.cpp": '#include <gtest/gtest.h>\n#include "sim/types/pose.h"\n',
}


def check(files: dict) -> subprocess.CompletedProcess:
    """Runs the check on a tree of path -> text."""
    with tempfile.TemporaryDirectory() as root:
        for name, text in files.items():
            file = pathlib.Path(root) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return subprocess.run([sys.executable, CHECK, root], capture_output=True, text=True, check=False)


class CheckTests(unittest.TestCase):
    def assert_refused(self, files: dict, problem: str):
        result = check(MIRROR | files)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertEqual([problem], result.stdout.splitlines())

    def assert_passes(self, files: dict):
        result = check(MIRROR | files)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_mirror_with_helpers_of_all_tests_passes(self):
        self.assert_passes({})

    def test_a_folder_that_mirrors_none_is_named(self):
        self.assert_refused({"tests/types/CMakeLists.txt": ""}, "tests/types mirrors no folder: there is no types")
        self.assert_refused(
            {"tests/sim/types/places/CMakeLists.txt": ""},
            "tests/sim/types/places mirrors no folder: there is no sim/types/places",
        )

    def test_a_test_of_another_folder_is_named(self):
        self.assert_refused(
            {"tests/sim/types/scene_test.cpp": '#include "sim/types_of_plants/scene.h"\n#include "sim/truth/scene.h"\n'},
            "tests/sim/types/scene_test.cpp includes no header of sim/types",
        )
        self.assert_refused({"tests/lone_test.cpp": '#include "sim/types/pose.h"\n'}, "tests/lone_test.cpp includes no header of .")

    def test_a_header_of_the_tests_may_include_it(self):
        header = {"tests/sim/types/poses.h": '#include "sim/types/pose.h"\n'}
        self.assert_passes(header | {"tests/sim/types/turn_test.cpp": '#include "tests/sim/types/poses.h"\n'})
        loop = {"tests/sim/types/poses.h": '#include "tests/sim/types/poses.h"\n'}
        self.assert_refused(
            loop | {"tests/sim/types/turn_test.cpp": '#include "tests/sim/types/poses.h"\n'},
            "tests/sim/types/turn_test.cpp includes no header of sim/types",
        )

    def test_tests_of_the_program_run_it(self):
        self.assert_passes({"tests/benchmarks/app/verbs_test.cpp": '#include "tests/benchmarks/app/program.h"\n'})
        self.assert_refused(
            {"tests/sim/types/verbs_test.cpp": '#include "tests/benchmarks/app/program.h"\n'},
            "tests/sim/types/verbs_test.cpp includes no header of sim/types",
        )


if __name__ == "__main__":
    unittest.main()
