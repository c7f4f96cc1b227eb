"""``python -m lipsync_lang``: the command line."""

import sys

from lipsync_lang.cli import main

sys.exit(main())
