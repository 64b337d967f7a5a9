#!/usr/bin/env python3
"""scripts/check_includes.py on small trees that break its table."""

import itertools
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).parents[2] / "scripts" / "check_includes.py"
ROOMS = ("calibration/boards", "calibration/solve", "calibration/bundle", "calibration/devices")


def check(files: dict) -> subprocess.CompletedProcess:
    """Runs the check on a tree of path -> text."""
    with tempfile.TemporaryDirectory() as root:
        for name, text in files.items():
            file = pathlib.Path(root) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return subprocess.run([sys.executable, CHECK, root], capture_output=True, text=True, check=False)


class CheckIncludes(unittest.TestCase):
    def assert_refused(self, files: dict, problem: str):
        result = check(files)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn(problem, result.stdout.splitlines())

    def assert_truth_is_not_linked_from(self, folder: str):
        for target in ("truth", "dataset_truth", "render"):
            with self.subTest(folder=folder, target=target):
                self.assert_refused(
                    {f"{folder}/CMakeLists.txt": f"cousin_library(mine SOURCES a.cpp PRIVATE types {target})\n"},
                    f"{folder}/CMakeLists.txt: {folder.split('/')[0]} must not link {target}",
                )

    def test_what_the_table_allows_passes(self):
        result = check(
            {
                "sim/types/pose.h": "#pragma once\n#include <vector>\n",
                "sim/truth/scene.h": '#include "sim/types/pose.h"\n',
                "perception/mvs/sweep.cpp": '#include "sim/types/pose.h"\n#include "perception/mvs/sweep.h"\n',
                "perception/mvs/sweep.h": "",
                "benchmarks/loop/score.cpp": '#include "sim/truth/scene.h"\n#include "perception/mvs/sweep.h"\n',
            }
        )
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_forbidden_include_is_named_with_its_file(self):
        self.assert_refused(
            {"sim/types/pose.h": '#pragma once\n  #  include "sim/render/truth_pass.h"\n', "sim/render/truth_pass.h": ""},
            "sim/types/pose.h: sim/types may not include sim/render (sim/render/truth_pass.h)",
        )
        self.assert_refused(
            {"sim/render/pass.cpp": '#include "scenes/seeds/seeds_scene.h"\n'},
            "sim/render/pass.cpp: sim/render may not include scenes (scenes/seeds/seeds_scene.h)",
        )

    def test_perception_and_calibration_never_include_the_truth(self):
        for folder in ("perception/deep/er", "calibration", *ROOMS):
            for truth in ("sim/truth/scene.h", "sim/dataset/truth_io.h", "sim/dataset/truth_json.h"):
                with self.subTest(folder=folder, truth=truth):
                    self.assert_refused(
                        {f"{folder}/file.cpp": f'#include "{truth}"\n', truth: ""},
                        f"{folder}/file.cpp: {folder.split('/')[0]} must never see the truth ({truth})",
                    )

    def test_rooms_of_calibration_include_each_other_one_way(self):
        allowed = {("solve", "boards"), ("bundle", "boards"), ("bundle", "solve"), ("devices", "boards"), ("devices", "solve")}
        for folder, other in itertools.permutations(ROOMS, 2):
            name, include = f"{folder}/file.cpp", f"{other}/file.h"
            with self.subTest(name=name, include=include):
                files = {name: f'#include "{include}"\n', include: ""}
                if tuple(room.split("/")[1] for room in (folder, other)) in allowed:
                    self.assertEqual(check(files).returncode, 0)
                else:
                    self.assert_refused(files, f"{name}: {folder} may not include {other} ({include})")

    def test_perception_and_benchmarks_include_every_room_of_calibration(self):
        for room in ROOMS:
            for folder in ("perception/sfm", "benchmarks/loop"):
                with self.subTest(folder=folder, room=room):
                    include = f"{room}/file.h"
                    result = check({f"{folder}/file.cpp": f'#include "{include}"\n', include: ""})
                    self.assertEqual(result.returncode, 0, result.stdout)

    def test_a_file_in_no_folder_of_the_table_is_named(self):
        self.assert_refused({"calibration/file.h": "#pragma once\n"}, "calibration/file.h: no folder of the table holds it")

    def test_brackets_and_other_endings_do_not_hide_the_truth(self):
        for name in ("sweep.cpp", "sweep.hpp", "sweep.cc", "sweep.inl"):
            with self.subTest(name=name):
                self.assert_refused(
                    {f"perception/mvs/{name}": "#include <vector>\n#include <sim/truth/scene.h>\n"},
                    f"perception/mvs/{name}: perception must never see the truth (sim/truth/scene.h)",
                )

    def test_perception_does_not_include_what_includes_the_truth(self):
        for header in ("sim/render/ray_scene.h", "sim/physics/settle.h", "scenes/seeds/seeds_scene.h"):
            with self.subTest(header=header):
                result = check({"perception/mvs/sweep.cpp": f'#include "{header}"\n'})
                self.assertEqual(result.returncode, 1)
                self.assertIn(f"({header})", result.stdout)

    def test_the_rest_of_the_dataset_does_not_include_its_truth(self):
        self.assert_refused(
            {"sim/dataset/capture_io.cpp": '#include "sim/dataset/truth_io.h"\n', "sim/dataset/truth_io.h": ""},
            "sim/dataset/capture_io.cpp: sim/dataset may not include sim/dataset/truth (sim/dataset/truth_io.h)",
        )

    def test_perception_does_not_link_the_truth(self):
        self.assert_truth_is_not_linked_from("perception/mvs")

    def test_no_room_of_calibration_links_the_truth(self):
        for folder in ("calibration", *ROOMS):
            self.assert_truth_is_not_linked_from(folder)

    def test_perception_does_not_link_what_links_the_truth(self):
        tree = {
            "sim/plant/CMakeLists.txt": "cousin_library(plant SOURCES plant.cpp\n  PUBLIC types truth PRIVATE geometry)\n",
            "scenes/maize/CMakeLists.txt": "cousin_library(scene_maize SOURCES maize.cpp PUBLIC plant)\n",
            "sim/geometry/CMakeLists.txt": "cousin_library(geometry SOURCES hull.cpp PUBLIC types)\n",
        }
        for target in ("plant", "scene_maize"):
            with self.subTest(target=target):
                self.assert_refused(
                    tree | {"perception/mvs/CMakeLists.txt": f"cousin_library(mvs SOURCES a.cpp PRIVATE {target})\n"},
                    f"perception/mvs/CMakeLists.txt: perception must not link {target}",
                )
        result = check(tree | {"perception/mvs/CMakeLists.txt": "cousin_library(mvs SOURCES a.cpp PRIVATE geometry)\n"})
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_an_include_of_nothing_is_named(self):
        self.assert_refused(
            {"sim/types/pose.h": '#include "pose_detail.h"\n'},
            'sim/types/pose.h: "pose_detail.h" is not below the root',
        )


if __name__ == "__main__":
    unittest.main()
