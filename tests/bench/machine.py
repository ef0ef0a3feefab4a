"""Names the machine that timings were taken on."""
import os
import platform
import subprocess
from pathlib import Path

from smidgen.build.binary import FLAGS, find_compiler


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def machine() -> str:
    """Processor, cores, compiler and flags in one line."""
    compiler = subprocess.run([*find_compiler(), "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    return f"{processor()}, {os.cpu_count()} cores; {compiler}; {' '.join(FLAGS)}"
