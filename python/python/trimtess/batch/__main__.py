"""`python -m trimtess.batch` is `trimtess-batch`."""

import sys

from .cli import main

sys.exit(main())
