"""Writes the tables of the pins anew, or says how far the program is from them.

    python tests/pins/write.py [NAME...]            run the pins and write their tables; all short ones by default
    python tests/pins/write.py --compare [NAME...]  write nothing: largest relative difference of each to its table

NAME is that of a table, such as overhand-rod or overhand-rod-whole.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numba

sys.path.insert(0, str(Path(__file__).parent))

from pinned import SHORT, WHOLE


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    pins = {pin.name: pin for pin in (*SHORT, *WHOLE)}
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--compare", action="store_true")
    asked = parser.parse_args()
    if unknown := set(asked.names) - set(pins):
        parser.error(f"no pin {', '.join(sorted(unknown))}; there are {', '.join(pins)}")
    numba.set_num_threads(1)
    for name in asked.names or [pin.name for pin in SHORT]:
        began = time.process_time()
        curve = pins[name].run()
        took = f"{time.process_time() - began:5.1f} s CPU"
        if asked.compare:
            print(f"{name:24} {took}  largest relative difference {pins[name].deviation(curve):.3g}", flush=True)
        else:
            pins[name].write(curve)
            print(f"{name:24} {took}  written", flush=True)


if __name__ == "__main__":
    main()
