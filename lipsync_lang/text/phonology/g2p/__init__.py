"""Text to phonemes (G2P): each engine is a file here, registered by name in `G2P_ENGINES`.

What an engine gives are words with labels of one notation. Which engine reads a language, and
what its labels stand for, is the language pack's word.
"""

import lazy_loader

# The stub lists the names. A performer needs tokens alone, and no engines.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
