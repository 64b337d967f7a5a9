#!/usr/bin/env python3
"""Keeps tests/ the mirror of the tree: a test of FOLDER lies in tests/FOLDER.

    check_tests.py [ROOT]

Reports each folder below tests that has a CMakeLists.txt and no folder of that name in the tree, and each *_test.cpp
that includes no header of the folder it mirrors, neither itself nor by a header below tests.
"""

import pathlib
import re
import sys

HELPERS = ("places", "fuzz", "scripts")  # of all tests
# folder -> another one, a header of which is enough too
THROUGH = {
    "benchmarks/app": "tests/benchmarks/app/program.h",  # runs the program
}
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def is_in(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + "/")


def includes(root: pathlib.Path, file: pathlib.Path) -> set:
    """Headers that a test includes, and those that its headers below tests include."""
    seen, todo = set(), [file]
    while todo:
        new = set(INCLUDE.findall(todo.pop().read_text())) - seen
        seen |= new
        todo += [root / name for name in new if is_in(name, "tests") and (root / name).is_file()]
    return seen


def check(root: pathlib.Path) -> list:
    tests, problems = root / "tests", []
    for file in sorted(tests.rglob("CMakeLists.txt")):
        folder = file.parent.relative_to(tests).as_posix()
        if folder != "." and folder.split("/")[0] not in HELPERS and not (root / folder).is_dir():
            problems.append(f"tests/{folder} mirrors no folder: there is no {folder}")
    for file in sorted(tests.rglob("*_test.cpp")):
        folder = file.parent.relative_to(tests).as_posix()
        enough = [folder] + [other for top, other in THROUGH.items() if is_in(folder, top)]
        if not any(is_in(name, start) for name in includes(root, file) for start in enough):
            problems.append(f"{file.relative_to(root).as_posix()} includes no header of {folder}")
    return problems


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    problems = check(root)
    print("\n".join(problems) if problems else "tests mirror the tree")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
