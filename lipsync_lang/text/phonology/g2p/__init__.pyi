# The public names of the room; each is imported from its module on first use.

from .corrections import engine as engine
from .g2p_engines import G2P_ENGINES as G2P_ENGINES
from .g2p_engines import RESPELLERS as RESPELLERS
from .g2p_engines import Settings as Settings
from .g2p_engines import SpokenWord as SpokenWord
