"""`python -m smidgen` is the command `smidgen`."""
import sys

from .cli import main

sys.exit(main())
