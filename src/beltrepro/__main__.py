"""`python -m beltrepro` is the command `beltrepro`."""

import sys

from beltrepro.cli.app import main

if __name__ == "__main__":
    sys.exit(main())
