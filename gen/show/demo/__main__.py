"""`python -m smidgen.show.demo --out out/demo`."""
import sys

from .stages import main

if __name__ == "__main__":
    sys.exit(main())
