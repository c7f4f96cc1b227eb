"""Schedules: timed phonemes, read from the files of many programs.

Times are seconds. A schedule is contiguous: phoneme i lasts from ``times[i]`` to
``times[i + 1]``. Silence is a phoneme like any other, written `SILENCE`. Labels are kept as
the file or the engine wrote them; a language pack turns them into common phonemes.

One file per input format; `reader` is all that makes a format known.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
