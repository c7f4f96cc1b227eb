# The public names of the room; each is imported from its module on first use.

from .matrix import coverage as coverage
from .report import Coverage as Coverage
