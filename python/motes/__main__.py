"""`python -m motes`: the command line, see `motes.cli`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
