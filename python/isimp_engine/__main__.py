"""`python -m isimp_engine` is the command `isimp`."""

import sys

from .cli import main

sys.exit(main())
