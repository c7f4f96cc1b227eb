"""The program: ``lipsync-lang``, or ``python -m lipsync_lang``."""

import atexit
import gc
import os
import sys


def main() -> int:
    """Run the command of this process, and return its exit code."""
    gc.set_threshold(100_000)  # before the imports: a start makes many objects, and drops few
    atexit.register(gc.freeze)  # the end would look for cycles among all objects, in vain
    # Pydantic would look for plug-ins of its own in all installed packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Idle threads of NumPy's linear algebra would keep their processors busy at every start.
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")  # 2**4 cycles, the least
    from lipsync_lang import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
