#!/usr/bin/env python3
"""Finds types that are defined twice.

    check_names.py [ROOT]

The program links every library into one: two headers that give different structs one name break the one definition
rule, and the linker keeps one of their destructors for both. Reads the headers below sim, scenes, calibration,
perception and benchmarks and reports each type of the namespace that more than one of them defines.
"""

import collections
import pathlib
import re
import sys

ROOTS = ("sim", "scenes", "calibration", "perception", "benchmarks")
# At the start of a line: types within types are indented.
TYPE = re.compile(r"^(?:struct|class|enum class|union) (?:alignas\(\w+\) )?(\w+)(?: final)?(?: : [^{;]*)? ?\{", re.MULTILINE)


def check(root: pathlib.Path) -> list:
    places = collections.defaultdict(list)
    for top in ROOTS:
        for file in sorted((root / top).rglob("*.h")):
            for name in TYPE.findall(file.read_text()):
                places[name].append(file.relative_to(root).as_posix())
    return [f"{name} is defined in {' and '.join(files)}" for name, files in sorted(places.items()) if len(files) > 1]


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    problems = check(root)
    print("\n".join(problems) if problems else "every type has one definition")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
