"""`python -m trimtess.batch` is `trimtess-batch`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
