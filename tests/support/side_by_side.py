"""Whether the compiler vectorises a loop over pairs, whatever the processor.

A separate process sets the vector width. The compiler then decides by the loop alone, not by what
pays on this processor. It does not vectorise a loop that calls functions, writes or branches. If an
index may count from the end, each number is read by itself. The test reads the intermediate code,
before instructions are selected.
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
