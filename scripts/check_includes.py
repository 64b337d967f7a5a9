#!/usr/bin/env python3
"""Keeps the folder table of the architecture true: which folder may include which.

    check_includes.py [ROOT]

Reads every C++ file below sim, scenes, calibration, perception and benchmarks and reports each #include of ours that
its folder may not reach, and each file that is in no folder of the table. Permission is transitive, except that calibration and perception never reach the truth: not
by an include, and not by a link edge in a CMakeLists.txt.
"""

import pathlib
import re
import sys

# folder -> folders it may include; permission is transitive. The longest matching folder counts. A folder without a row,
# as `sim`, stands for all rows below it.
MAY_INCLUDE = {
    "sim/types": [],
    "sim/config": ["sim/types"],
    "sim/process": ["sim/types"],
    "sim/truth": ["sim/types"],
    "sim/imaging": ["sim/types"],
    "sim/geometry": ["sim/types"],
    "sim/dataset": ["sim/types", "sim/config", "sim/imaging", "sim/geometry"],
    "sim/dataset/truth": ["sim/dataset", "sim/truth"],
    "sim/plant": ["sim/truth", "sim/geometry", "sim/config"],
    "sim/physics": ["sim/truth", "sim/geometry", "sim/config"],
    "sim/render": ["sim/truth", "sim/geometry", "sim/config"],
    "sim/render/cycles": ["sim/render", "sim/imaging", "sim/process"],
    "sim/sensors": ["sim/render", "sim/imaging", "sim/config"],
    "scenes": ["sim/truth", "sim/geometry", "sim/plant", "sim/physics", "sim/render", "sim/config"],
    "calibration/boards": ["sim/types", "sim/imaging", "sim/config", "sim/dataset"],
    "calibration/solve": ["calibration/boards"],
    "calibration/bundle": ["calibration/solve"],
    "calibration/devices": ["calibration/solve"],
    "perception": ["sim/types", "sim/imaging", "sim/config", "sim/geometry", "sim/dataset", "sim/process", "calibration"],
    "benchmarks/score": ["sim/types", "sim/truth", "sim/geometry", "sim/imaging", "sim/config"],
    "benchmarks/score/learned": ["benchmarks/score"],
    "benchmarks/report": ["benchmarks/score"],
    "benchmarks/study": ["benchmarks/score", "sim/config", "sim/dataset"],
    "benchmarks/loop": ["benchmarks/score", "benchmarks/score/learned", "benchmarks/report", "benchmarks/study", "sim", "sim/dataset/truth",
                        "scenes", "calibration", "perception"],
    "benchmarks/tools": ["benchmarks/loop"],
    "benchmarks/suites": ["benchmarks/loop", "benchmarks/tools"],
    "benchmarks/app": ["benchmarks/suites"],
}
# Files of the dataset's truth target; the rest of sim/dataset must not see the truth.
TRUTH_FILES = (
    "sim/dataset/truth_format",
    "sim/dataset/truth_io",
    "sim/dataset/truth_json",
    "sim/dataset/truth_sensors",
    "sim/dataset/scene_look_json",
    "sim/dataset/environment_io",
    "sim/dataset/export/",
)
TRUTH = "sim/truth"
NEVER_TRUTH = ("calibration", "perception")
TRUTH_TARGETS = {"truth", "dataset_truth", "render"}  # and whatever links one of them: `truth_targets`
ROOTS = ("sim", "scenes", "calibration", "perception", "benchmarks")
SUFFIXES = (".h", ".hh", ".hpp", ".hxx", ".inl", ".ipp", ".tpp", ".c", ".cc", ".cpp", ".cxx", ".cu")
# Between brackets only what starts with a folder of ours: the rest is a library's.
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<((?:' + "|".join(ROOTS) + r')/[^>]+)>)', re.MULTILINE)

LIBRARY = re.compile(r"cousin_library\(\s*(\w+)\s([^)]*)\)")


def folder_of(path: str) -> str:
    """The row of MAY_INCLUDE that a file belongs to."""
    if path.startswith(TRUTH_FILES):
        return "sim/dataset/truth"
    rows = [row for row in MAY_INCLUDE if path == row or path.startswith(row + "/")]
    return max(rows, key=len) if rows else ""


def reach(folder: str) -> set:
    """All rows a folder may include, itself too."""
    seen, todo = set(), [folder]
    while todo:
        row = todo.pop()
        if row in seen:
            continue
        seen.add(row)
        children = [] if row in MAY_INCLUDE else [r for r in MAY_INCLUDE if r.startswith(row + "/")]
        todo += MAY_INCLUDE.get(row, []) + children
    return seen


def truth_targets(root: pathlib.Path) -> set:
    """Targets of sim and scenes that link the truth, directly or through others."""
    files = (file for top in ("sim", "scenes") for file in (root / top).rglob("CMakeLists.txt"))
    calls = [call for file in files for call in LIBRARY.findall(file.read_text())]
    found, size = set(TRUTH_TARGETS), 0
    while len(found) > size:
        size = len(found)
        found |= {name for name, words in calls if found & set(words.split())}
    return found


def check(root: pathlib.Path) -> list:
    problems = []
    for top in ROOTS:
        for file in sorted((root / top).rglob("*")):
            if file.suffix not in SUFFIXES:
                continue
            name = file.relative_to(root).as_posix()
            folder = folder_of(name)
            if not folder:
                problems.append(f"{name}: no folder of the table holds it")
            allowed = reach(folder)
            for quoted, bracketed in INCLUDE.findall(file.read_text()):
                include = quoted or bracketed
                target = folder_of(include)
                if not target:
                    if not (root / include).exists():
                        problems.append(f"{name}: \"{include}\" is not below the root")
                    continue
                if folder and target not in allowed:
                    problems.append(f"{name}: {folder} may not include {target} ({include})")
                if top in NEVER_TRUTH and target in (TRUTH, "sim/dataset/truth"):
                    problems.append(f"{name}: {top} must never see the truth ({include})")
    targets = truth_targets(root)
    for top in NEVER_TRUTH:
        for file in sorted((root / top).rglob("CMakeLists.txt")):
            words = set(re.findall(r"\w+", file.read_text()))
            for target in sorted(words & targets):
                problems.append(f"{file.relative_to(root)}: {top} must not link {target}")
    return problems


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    problems = check(root)
    print("\n".join(problems) if problems else "includes agree with the folder table")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
