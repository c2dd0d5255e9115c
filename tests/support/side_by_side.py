"""Whether a loop over pairs can do several of them at a time, on whatever processor.

The compiler is told how many to take, in a process of its own: it then asks of the loop alone
whether that is possible, and not of the processor whether it pays. A loop that calls something,
writes, or branches is not taken; one whose index may count from the end reads every number by
itself. The form that is looked at is that before it is made into the instructions of a processor.
"""

import re
import subprocess
import sys

AT_A_TIME = 4

SCRIPT = f"""
import llvmlite.binding
llvmlite.binding.set_option("", "-force-vector-width={AT_A_TIME}")
import numba
{{lines}}
rows, number, index = numba.float64[:, ::1], numba.float64, numba.int64
options = {{{{key: function.targetoptions[key] for key in ("fastmath", "error_model")}}}}
fresh = numba.njit(function.py_func, **options)
fresh.compile((rows,) * {{tables}} + (number, index, index, index))
(code,) = fresh.inspect_llvm().values()
print(code)
"""


def reads_of_the_loop(lines: str, tables: int) -> tuple[int, int]:
    """Numbers read side by side, and one by one, by the ``function`` that these lines define."""
    script = SCRIPT.format(lines=lines, tables=tables)
    command = [sys.executable, "-c", script]
    code = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    together = rf"<{AT_A_TIME} x double>"
    blocks = [b for b in re.split(r"\n(?=\S+:)", code) if re.search(rf"fmul.* {together}", b)]
    wide = sum(len(re.findall(rf"= load {together}", block)) for block in blocks)
    single = [b for b in blocks if re.search(r"= load double|gather", b)]
    return wide, len(single)
