"""The hard suite: cases at the edge of what a step can do, each with what must happen there."""
import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
sys.path += [folder for folder in map(str, sorted({path.parent for path in TESTS.rglob("test_*.py")})) if folder not in sys.path]     # whose helpers some cases share
