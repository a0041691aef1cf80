"""Adds up by stage what callgrind counted in one run of fleetpub: instructions, and time in system calls.

  stages.py CALLGRIND RUN ROBOTS CSV

Appends to CSV. A stage's cost is that of its functions with all that they call, without the stages within it. A function that
is not there any more, or that the optimiser has built into its caller, makes this fail: then the table below is to be mended.
"""

import csv
import os
import re
import subprocess
import sys

# (stage, its functions, the stage that they are called in). All else below main is `rest`; what is not below main, `start`.
STAGES = [
    ("arguments", ["cli::Call::Read", "cli::Call::Configure"], None),
]


def main():
    callgrind, run, robots, table = sys.argv[1:]


main()
