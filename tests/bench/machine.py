"""Names the machine that timings were taken on, and writes their tables."""
import csv
import datetime
import os
import platform
import re
import subprocess
from pathlib import Path

from smidgen.build.binary import FLAGS, NATIVE, find_compiler, lanes_of

COSTS = Path(__file__).resolve().parents[2] / "docs" / "cost"


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def machine() -> str:
    """Processor, cores, numbers in its vectors, compiler, flags and the day in one line."""
    compiler = subprocess.run([*find_compiler(), "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    lanes = lanes_of(find_compiler(), NATIVE)
    return f"{processor()}, {os.cpu_count()} cores, {lanes} lanes; {compiler}; {' '.join(FLAGS)}; {datetime.date.today()}"


def cost_tables(folder: Path = COSTS) -> Path:
    """Where the cost tables of this machine's vectors stand: those of other widths stay beside them."""
    return folder / f"lanes_{lanes_of(find_compiler(), NATIVE)}"


def write_table(path, lines: list, columns=None, flags: str = "") -> None:
    """A CSV of dicts below a line that names the machine, more flags of the compiler and the load; printed too."""
    with open(path, "w", newline="") as f:
        f.write(f"# {machine()}{flags}; load {os.getloadavg()[0]:.1f}\n")
        writer = csv.DictWriter(f, columns or list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)
    for line in lines:
        print(line)


def put_between(page: Path, begin: str, end: str, text: str) -> None:
    """Replaces what stands between two lines of a page."""
    page.write_text(re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: begin + text + end, page.read_text(), flags=re.DOTALL))
