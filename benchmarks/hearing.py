"""Errors of alignment in recordings of any language, and the confidence of the aligner.

    python benchmarks/hearing.py DATA [--aligner NAME] [--only SECTION ...] [--json FILE]

DATA is a folder of foreign recordings: `recordings/mfa_tests`, `articulography`, `text/udhr`.
Beside them, Festival's voices speak six languages, where Festival and they are installed: voices
that were cut from recordings of people, and whose times are exact.

Sections: `boundaries` compares starts of words, and of phonemes with pressed lips, with the known
ones; `texts` aligns each recording with its text and with wrong ones; `beside` puts music, noise or
another voice before or after a line, and states how far its words move; `long` joins recordings
with pauses, and states how far the edges of utterances are off those of each by itself.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import json_figures
import numpy as np
import warping
from closures import FRAMES_OFF, by_place, closures, print_places

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.sound import read_audio, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

RATE = 16_000
LABIAL = tuple("pbm")
"""First signs of labels with pressed lips, in IPA and in the phone sets of Festival's voices."""
EDGE = 0.3
FESTIVAL = {
    "catalan": ("upc_ca_ona_hts", "latin-1", (
        "La casa gran tenia una porta petita i blava.",
        "Demà al matí anirem a buscar bolets prop del poble.",
        "No sé pas on has posat les claus del cotxe.",
        "Per què no vens a sopar amb nosaltres?",
    )),
    "italian": ("pc_diphone", "latin-1", (
        "La bambina porta il pane alla mamma.",
        "Domani mattina andremo al mare con gli amici.",
        "Non so dove ho messo le chiavi della macchina.",
        "Prendi la borsa blu e vieni subito qui.",
    )),
    "czech": ("czech_dita", "iso8859-2", (
        "Malý pes běžel přes most domů.",
        "Pan prezident bude mluvit s novináři.",
        "Babička peče dobré koláče s mákem.",
    )),
    "finnish": ("hy_fi_mv_diphone", "latin-1", (
        "Poika juoksi metsän läpi kotiin.",
        "Huomenna menemme järvelle kalastamaan.",
        "Pieni punainen mökki on mäen päällä.",
    )),
    "russian": ("msu_ru_nsh_clunits", "utf-8", (
        "Маленькая собака бежала через мост домой.",
        "Президент будет говорить с журналистами.",
        "Мама купила хлеб и молоко.",
    )),
    "telugu": ("telugu_NSK_diphone", "utf-8", (
        "నేను రేపు ఊరికి వెళ్తాను",
        "ఈ పుస్తకం బల్ల మీద పెట్టు",
    )),
}  # fmt: skip
NATURAL = {
    "spanish": ("13697_11991_000000.opus",),
    "japanese": ("common_voice_ja_24511055.mp3",),
    "swedish": tuple(f"se10x016-08071999-1334_u001600{n}.wav" for n in "234"),
    "english": (
        "61-70968-0000.flac",
        *(f"common_voice_en_2205826{n}.mp3" for n in "467"),
        *(f"multilingual_ipa{end}.flac" for end in ("", "_2", "_4", "_5")),
        *(f"multilingual_ipa_us_{number}.flac" for number in (2, 3, 5)),
    ),
}  # fmt: skip
SOURCES = {
    "spanish": "spa", "english": "eng", "swedish": "swe", "german": "deu_1996", "catalan": "cat",
    "italian": "ita", "czech": "ces", "finnish": "fin", "russian": "rus", "telugu": "tel",
}  # fmt: skip
"""Files of the Universal Declaration, which wrong texts are cut from."""


class Recording(NamedTuple):
    """A recording with its text; `known` are starts of words and of pressed lips, in seconds."""

    language: str
    audio: Audio
    text: str
    known: tuple[list[float], list[float]] | None = None


def natural(data: Path) -> Iterator[Recording]:
    """Yield the natural recordings of a folder with their texts."""
    folder = data / "recordings" / "mfa_tests"
    for language, names in NATURAL.items():
        for path in (folder / name for name in names):
            script = next(p for end in (".lab", ".txt") if (p := path.with_suffix(end)).exists())
            yield Recording(language, read_audio(path), script.read_text("utf-8").strip().lower())
    for text, true in warping.german(data / "articulography"):
        yield Recording("german", true.audio, text)


def spoken() -> Iterator[Recording]:
    """Yield what Festival's voices say, and when."""
    for language, (voice, encoding, texts) in FESTIVAL.items():
        for text in texts:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                saved = " ".join(
                    f'(utt.save.{kind} said "{folder / kind}")'
                    for kind in ("wave", "segs", "words")
                )
                script = f'(voice_{voice})(set! said (utt.synth (Utterance Text "{text}"))){saved}'
                (folder / "say.scm").write_bytes(script.encode(encoding, "replace"))
                try:
                    subprocess.run(  # noqa: S603 our own script
                        ["festival", "-b", folder / "say.scm"],  # noqa: S607 from the PATH
                        check=True,
                        capture_output=True,
                    )
                except (OSError, subprocess.CalledProcessError):
                    print(f"Festival's {voice} is not installed")
                    break
                rows = [_rows(folder / kind) for kind in ("segs", "words")]
                yield Recording(language, read_audio(folder / "wave"), text, _starts(*rows))


def _rows(path: Path) -> list[tuple[float, str]]:
    lines = path.read_text("latin-1").splitlines()[1:]
    fields = [line.split(None, 2) for line in lines]
    return [(float(end), label) for end, _, label in filter(_whole, fields)]


def _whole(fields: list[str]) -> bool:
    return len(fields) == 3


def _starts(
    segments: list[tuple[float, str]], words: list[tuple[float, str]]
) -> tuple[list[float], list[float]]:
    begins = [0.0, *(end for end, _ in segments[:-1])]
    sounds = [
        (begin, label)
        for begin, (_, label) in zip(begins, segments, strict=True)
        if label not in ("pau", "#", "_", "sil")
    ]
    ends = [0.0, *(end for end, _ in words)]
    starts = [
        min(begin for begin, _ in sounds if begin >= after - 1e-3) for after in ends[: len(words)]
    ]
    return starts, [begin for begin, label in sounds if label.startswith(LABIAL)]


class Bench:
    """Alignments by one aligner, or by the languages' own choice."""

    def __init__(self, aligner: str | None) -> None:
        self.aligner = aligner
        self.speakers: dict[str, Speaker] = {}
        self.sound = self.took = 0.0
        self.figures: dict[str, Any] = {}
        """Results of the sections, for `--json`."""

    def align(self, recording: Recording, text: str | None = None) -> Schedule:
        """Align a recording with its text or another."""
        speaker = self.speakers.setdefault(recording.language, Speaker.of(recording.language))
        began = time.process_time()
        found = aligned(speaker, recording.audio, text or recording.text, aligner=self.aligner)
        self.took += time.process_time() - began
        self.sound += recording.audio.seconds
        return found


def begins(schedule: Schedule) -> np.ndarray:
    """Return when each word begins."""
    return np.array([schedule.times[word.first] for word in schedule.words])


def told(name: str, off: list[float]) -> None:
    """Print a row of errors in milliseconds."""
    far = np.abs(off) * 1000
    print(
        f"{name:28}{len(far):6}{np.median(far):8.0f}{np.quantile(far, 0.9):8.0f}"
        f"{np.median(off) * 1000:+8.0f}{np.mean(far > 1000 * FRAMES_OFF):8.0%}",
        flush=True,
    )


def boundaries(bench: Bench, data: Path) -> None:
    """Print how far boundaries are off."""
    print(f"{'boundaries, ms':28}{'number':>6}{'median':>8}{'90 %':>8}{'late':>8}{'>33 ms':>8}")
    late: list[float] = []
    pressed: list[tuple[str, float]] = []
    for text, true in warping.german(data / "articulography"):
        found = bench.align(Recording("german", true.audio, text))
        late += [*warping.errors(found, true, bench.speakers["german"])]
        pressed += closures(found, true, bench.speakers["german"])
    told("german, all, by hand", late)
    print_places(places := by_place(pressed))
    bench.figures["german, all, by hand"] = json_figures.boundary_errors(late) | {"places": places}
    off: dict[str, list[float]] = defaultdict(list)
    lips: dict[str, list[float]] = defaultdict(list)
    for one in spoken():
        found, (words, pressed) = bench.align(one), one.known
        if len(found.words) == len(words):
            off[one.language] += [*(begins(found) - words)]
        here = [t for t, label in zip(found.times, found.labels, strict=False)
                if label.startswith(LABIAL)]  # fmt: skip
        if len(here) == len(pressed):
            lips["lip closures, all"] += [*np.subtract(here, pressed)]
    for name, errors in {**off, **lips}.items():
        told(name, errors)


def texts(bench: Bench, data: Path) -> None:
    """Print how many right and wrong texts are remarked on."""
    chance = random.Random(1)
    doubted: dict[str, list[bool]] = defaultdict(list)
    for one in (*natural(data), *spoken()):
        for kind, text in (("right", one.text), *wrong(one, data, chance)):
            try:
                sure = bench.align(one, text).confidence or 0.0
            except SpeechError:
                sure = 0.0
            doubted[kind].append(sure < DOUBTFUL)
    for kind, ones in doubted.items():
        print(f"{'remarked on, ' + kind:28}{len(ones):6}{np.mean(ones):8.1%}")
        bench.figures[kind] = {"texts": len(ones), "remarked_on": np.mean(ones)}


def wrong(one: Recording, data: Path, chance: random.Random) -> Iterator[tuple[str, str]]:
    """Yield wrong texts of a recording: its own in disorder, and those of other lines."""
    own = one.text.split()
    half = len(own) // 2
    if len(own) > 3:
        yield "halves exchanged", " ".join(own[half:] + own[:half])
        yield "shuffled", " ".join(chance.sample(own, len(own)))
        yield "a word missing", " ".join(own[:half] + own[half + 1 :])
    if one.language not in SOURCES:
        return
    file = data / "text" / "udhr" / f"{SOURCES[one.language]}.txt"
    words = [word.strip(".,;:()«»") for word in file.read_text("utf-8").split()][60:600]
    size = len(one.text.split())
    for kind, count in (
        ("as long", size),
        ("half", max(1, size // 2)),
        ("two words", 2),
        ("one", 1),
    ):
        start = chance.randrange(len(words) - count)
        yield kind, " ".join(words[start : start + count])


def beside(bench: Bench, data: Path) -> None:
    """Print how far words move where something else is heard before or after them."""
    chosen = [one for one in natural(data) if 3 < one.audio.seconds < 8][:8]
    other = next(one for one in natural(data) if one.audio.seconds > 10)
    random_ = np.random.default_rng(3)
    sounds = {
        "music": music(5.0),
        "noise": random_.normal(size=5 * RATE),
        "another voice": np.resize(resampled(other.audio, RATE).samples.astype(float), 5 * RATE),
    }
    print(f"{'words move, ms':28}{'number':>6}{'median':>8}{'90 %':>8}{'late':>8}{'>33 ms':>8}")
    for name, sound in sounds.items():
        for where in ("before", "after"):
            moved: list[float] = []
            for one in chosen:
                alone = begins(bench.align(one))
                said = resampled(one.audio, RATE).samples.astype(float)
                more = sound * said.std() / sound.std()
                whole = np.concatenate([more, said] if where == "before" else [said, more])
                audio = Audio(np.clip(whole, -32768, 32767).astype(np.int16), RATE)
                found = begins(bench.align(one._replace(audio=audio)))
                if len(found) == len(alone):
                    moved += [*(found - alone - (5.0 if where == "before" else 0.0))]
            told(f"{name} {where}", moved)


def music(seconds: float) -> np.ndarray:
    """Return chords that fade, at `RATE`."""
    times = np.arange(round(seconds * RATE)) / RATE
    chord = np.array([[220, 277, 330], [196, 247, 294]])[(times % 2).astype(int)]
    tones = sum(np.sin(2 * np.pi * chord * n * times[:, None]).sum(1) / n for n in range(1, 7))
    return np.asarray(tones * np.exp(-2 * (times % 0.5)))


def long(bench: Bench, data: Path) -> None:
    """Print how far edges of utterances are off in recordings that follow each other."""
    groups: dict[str, list[Recording]] = defaultdict(list)
    for one in (*natural(data), *spoken()):
        if one.audio.seconds > 2:
            groups[one.language].append(one)
    for language, ones in groups.items():
        if len(ones) < 3:
            continue
        pause = np.zeros(RATE // 2, np.int16)
        known: list[float] = []
        counts: list[int] = []
        sounds: list[np.ndarray] = []
        for one in ones:
            at = sum(map(len, sounds)) / RATE
            alone = bench.align(one)
            known += [at + begins(alone)[0], at + alone.times[alone.words[-1].stop]]
            counts.append(len(alone.words))
            sounds += [resampled(one.audio, RATE).samples, pause]
        audio = Audio(np.concatenate(sounds), RATE)
        script = " ".join(one.text.rstrip(".") + "." for one in ones)
        found = bench.align(Recording(language, audio, script))
        if len(found.words) != sum(counts):
            print(f"{language}: {len(found.words)} words of {sum(counts)}")
            continue
        stops = np.cumsum(counts)
        edges = [
            t
            for first, stop in zip(stops - counts, stops, strict=True)
            for t in (begins(found)[first], found.times[found.words[stop - 1].stop])
        ]
        far = np.abs(np.subtract(edges, known)) > EDGE
        name = f"{language}, {audio.seconds:.0f} s"
        print(f"{name:28}{len(far):6} edges, {np.mean(far):.1%} more than 0.3 s off")


SECTIONS = {"boundaries": boundaries, "texts": texts, "beside": beside, "long": long}


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--aligner")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS)
    json_figures.add_option(parser)
    options = parser.parse_args()
    kept = {}
    for name in options.only:
        bench = Bench(options.aligner)
        SECTIONS[name](bench, options.data)
        kept[name] = bench.figures
        print(f"{bench.sound / max(bench.took, 1e-9):.1f} s of sound per second of processor\n")
    json_figures.write_figures(options.json, kept)
    return 0


if __name__ == "__main__":
    sys.exit(main())
