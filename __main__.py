"""python -m iwis: the command line."""

import sys

from .iwis_addon.cli import main

if __name__ == "__main__":
    sys.exit(main())
