"""JSON for other programs: curves, phonemes and words."""

import json
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer


@writer("json", suffix=".json")
def write_json(animation: Animation, out: TextIO) -> None:
    """Pose names, a list of weights per frame, and the phonemes and words performed."""
    schedule = animation.schedule
    times = [round(t, 6) for t in schedule.times.tolist()]
    marks = schedule.stress or (None,) * len(schedule)
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
            for label, start, end, stress in zip(
                schedule.labels, times, times[1:], marks, strict=False
            )
        ],
        "words": [
            {"text": w.text, "start": times[w.first], "end": times[w.stop]}
            | ({"emphasis": w.emphasis} if w.emphasis else {})
            for w in schedule.words
        ],
    }
    head = json.dumps(document, ensure_ascii=False, indent=1)
    rows = (json.dumps([round(v, 5) for v in row]) for row in animation.weights.tolist())
    out.write(head[: head.rindex("\n}")] + ',\n "frames": [\n  ')
    out.write(",\n  ".join(rows))
    out.write("\n ]\n}\n")
