"""Lip sync for any language and any character, from data that people can read and edit.

    import lipsync_lang as ll

    performer = ll.resolve("english", "facefx")
    schedule = ll.speak("Hello, world", "english")
    animation = performer.perform(schedule, fps=60)
    animation.save("hello.csv")
    print(animation.explain(0.42))

Importing this is light: speech, plotting and YAML are loaded when they are used.
"""

import lazy_loader

# The stub lists the public names, once, for type checkers and for this call.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
