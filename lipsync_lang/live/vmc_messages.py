"""Messages of the VMC protocol (Virtual Motion Capture) over UDP, in bundles of OSC.

One bundle a frame: a `/VMC/Ext/Blend/Val` with name and weight for each pose, then
`/VMC/Ext/Blend/Apply`, which shows them. `/VMC/Ext/OK` before them announces the sender.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from lipsync_lang.errors import LipsyncError
from lipsync_lang.extras import install_line

if TYPE_CHECKING:
    from pythonosc.osc_message import OscMessage

    from lipsync_lang.live.outlets import LiveFrame

VALUE, APPLY, READY = "/VMC/Ext/Blend/Val", "/VMC/Ext/Blend/Apply", "/VMC/Ext/OK"

LOADED = 1
"""Value of `/VMC/Ext/OK`: a model is loaded."""


def vmc_messages(
    poses: Sequence[str], renamed: Mapping[str, str]
) -> "Callable[[LiveFrame], bytes]":
    """Return a function that packs frames.

    Parameters
    ----------
    poses : the name of each weight
    renamed : other names for some poses, from the receiver's model

    Raises
    ------
    LipsyncError
        python-osc is not installed.
    """
    try:
        from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
        from pythonosc.osc_message_builder import OscMessageBuilder
    except ImportError:
        raise LipsyncError(f"VMC needs the package python-osc: {install_line('live')}") from None

    def message(address: str, *values: tuple[str, str | float | int]) -> "OscMessage":
        made = OscMessageBuilder(address)
        for kind, value in values:
            made.add_arg(value, kind)
        return made.build()

    names = [renamed.get(pose, pose) for pose in poses]
    ready, apply = message(READY, ("i", LOADED)), message(APPLY)

    def pack(frame: "LiveFrame") -> bytes:
        bundle = OscBundleBuilder(IMMEDIATELY)
        bundle.add_content(ready)
        for name, weight in zip(names, frame.weights.tolist(), strict=True):
            bundle.add_content(message(VALUE, ("s", name), ("f", weight)))
        bundle.add_content(apply)
        packed: bytes = bundle.build().dgram
        return packed

    return pack
