"""Text to phonemes (G2P): each engine is a file here, registered by name in `G2P_ENGINES`.

What an engine gives are words with labels of one notation. Which engine reads a language, and
what its labels stand for, is the language pack's word.
"""

from lipsync_lang.text.phonology.g2p.corrections import engine as engine
from lipsync_lang.text.phonology.g2p.g2p_engines import G2P_ENGINES as G2P_ENGINES
from lipsync_lang.text.phonology.g2p.g2p_engines import RESPELLERS as RESPELLERS
from lipsync_lang.text.phonology.g2p.g2p_engines import Settings as Settings
from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord as SpokenWord
