"""``python -m plcruntime`` is ``scancycle``."""

import sys

from plcruntime.cli import main

sys.exit(main())
