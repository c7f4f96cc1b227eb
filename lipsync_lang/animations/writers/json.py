"""JSON for other programs: curves, phonemes and words."""

import json
from typing import TextIO

import numpy as np
import numpy.typing as npt

from lipsync_lang.animations.moving_shapes import in_words_of_model
from lipsync_lang.animations.writers import Animation, writer


@writer("json", suffix=".json")
def write_json(animation: Animation, out: TextIO) -> None:
    """Pose names, a list of weights per frame, and the phonemes and words performed."""
    animation, schedule = in_words_of_model(animation), animation.schedule
    times = [round(t, 6) for t in schedule.times.tolist()]
    marks = schedule.stress or (None,) * len(schedule)
    sounds = zip(schedule.labels, times, times[1:], marks, strict=False)
    document = {
        "format": "lipsync-lang animation 1",
        "fps": animation.fps,
        "start": round(float(animation.times[0]), 6),
        "offset": round(animation.offset, 6),
        "estimated": schedule.estimated,
        "language": schedule.language,
        "notation": schedule.notation,
        "poses": list(animation.poses),
        "phonemes": [
            {"label": label, "start": start, "end": end}
            | ({} if stress is None else {"stress": stress})
            for label, start, end, stress in sounds
        ],
        "words": [
            {"text": w.text, "start": times[w.first], "end": times[w.stop]}
            | ({"emphasis": w.emphasis} if w.emphasis else {})
            | ({} if w.confidence is None else {"confidence": round(w.confidence, 2)})
            for w in schedule.words
        ],
    }
    head = json.dumps(document, ensure_ascii=False, indent=1)
    rows = json.dumps(_rounded(animation.weights).tolist())
    out.write(head[: head.rindex("\n}")] + ',\n "frames": [\n  ')
    out.write(rows[1:-1].replace("], [", "],\n  ["))
    out.write("\n ]\n}\n")


def _rounded(weights: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Round to 5 digits as `round` does, to the last bit; it decides where floats are in doubt."""
    with np.errstate(all="ignore"):
        scaled = weights * 1e5
        rounded: npt.NDArray[np.float64] = np.rint(scaled) / 1e5
        sure = (np.abs(scaled - np.floor(scaled) - 0.5) > 1e-6) & (np.abs(scaled) < 1e9)  # noqa: PLR2004
    for place in np.argwhere(~sure).tolist():
        rounded[tuple(place)] = round(float(weights[tuple(place)]), 5)
    return rounded
