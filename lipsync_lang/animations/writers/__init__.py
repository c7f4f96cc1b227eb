"""Writers of animations, one module per output format.

To add one, write a module in `plugins/programs`, which has an entry point, with a function
``(animation, stream) -> None`` under ``@writer("name", suffix=".suffix")`` of `animation_writers`,
or ``@binary_writer`` for bytes. It knows only `Animation`, and imports heavy libraries inside the
function. The first line of its docstring appears in `formats` and in the documentation. Then run
`docs/build_reference.py`. The tests sweep over all writers, and need a function that reads the file
back (`READ_BACK`).
"""

from lipsync_lang.animations.animation import Animation as Animation
from lipsync_lang.animations.animation_writers import binary_writer as binary_writer
from lipsync_lang.animations.animation_writers import template as template
from lipsync_lang.animations.animation_writers import writer as writer
