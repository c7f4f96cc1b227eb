"""Draft of a language pack from a voice, an Epitran code, a table of spellings or an inventory.

A draft is valid without manual edits. It maps each label to the nearest common phonemes by visible
articulatory features; doubtful labels are listed first, with their lost features. Tests are left
empty, because expected results must come from a source independent of this program.

An inventory is an ordered tuple of IPA segments without repeats, with its source. File sizes are in
bytes after decompression.
"""

import csv
import gzip
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from itertools import chain, islice
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

from lipsync_lang.authoring.new_pack import PackDraft, PackWish, check_name, from_template
from lipsync_lang.base.errors import LipsyncError, PackError, did_you_mean
from lipsync_lang.base.files.reading import MIB_BYTES, read_input, utf8_text
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs.finding import FOLDERS, IPA
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Sounds
from lipsync_lang.packs.yaml.value_text import as_scalar
from lipsync_lang.resolver.nearest_phonemes import among_all
from lipsync_lang.text.phonology.g2p import Settings, engine
from lipsync_lang.text.phonology.g2p.lexicon import read_lexicon
from lipsync_lang.text.phonology.g2p.orthography_profile import read_profile
from lipsync_lang.text.phonology.labels import normalise
from lipsync_lang.text.phonology.nearest import Nearest

ID_COLUMNS = ("InventoryID", "inventory_id")
SEGMENT = ("Phoneme", "phoneme_raw", "phoneme", "segment")
NAME_COLUMNS = ("LanguageName", "language")
CODE_COLUMNS = ("ISO6393", "iso6393")
SOURCE = ("Source", "source")
"""Column names: first of the PHOIBLE file itself, then of tables derived from it."""

SHOWN_INVENTORIES = 12

MAX_INVENTORY_BYTES = 128 * MIB_BYTES
"""Upper limit of the decompressed size in bytes; the PHOIBLE table has 24 million."""

NUMBERS = tuple(str(n) for n in (*range(21), *range(30, 100, 10), 21, 45, 78, 100, 1000, 1000000))
"""Sample texts for any voice: number words, which cover most sounds of a language."""

LIST_WIDTH = 96
"""Maximum length of a line that lists labels."""


class Inventory(NamedTuple):
    """The segments of a language and their source."""

    source: str
    segments: tuple[str, ...]
    language: str = ""
    code: str = ""


def read_inventory(path: Path, which: str | None = None) -> Inventory:
    """Read one inventory.

    `path` is the PHOIBLE table (.csv or .tsv, optionally gzipped), or plain text of segments
    separated by white space; `which` is an inventory number, ISO 639-3 code or language name in the
    table. Raises LipsyncError if the file is unreadable, or the number of matching inventories is
    not one.
    """
    text = _text(path)
    first = text.partition("\n")[0]
    if not any(name in first for name in SEGMENT) or not any(name in first for name in ID_COLUMNS):
        segments = tuple(dict.fromkeys(text.split()))
        if not segments:
            raise LipsyncError(f"{path}: has no segments; write them with spaces between them")
        return Inventory(path.name, segments)
    found = dict(_inventories(text))
    if which is None:
        mend = "name one by number, ISO 639-3 code or language: --inventory-id 2269"
        raise LipsyncError(f"{path}: holds {len(found)} inventories; {mend}")
    if which in found:
        return found[which]
    key = which.casefold()
    fits = {n: i for n, i in found.items() if key in (i.code.casefold(), i.language.casefold())}
    if len(fits) == 1:
        return next(iter(fits.values()))
    if fits:
        listed = ", ".join(
            f"{n} ({len(i.segments)} segments)" for n, i in [*fits.items()][:SHOWN_INVENTORIES]
        )
        raise LipsyncError(f"{path}: several inventories match '{which}'; name one: {listed}")
    names = {n for i in found.values() for n in (i.language, i.code) if n}
    raise LipsyncError(f"{path}: has no inventory '{which}'; {did_you_mean(which, names)}")


def _text(path: Path) -> str:
    mend = "check that it is a table of phonemes"
    raw = read_input(path, MAX_INVENTORY_BYTES, mend=mend)
    try:
        if raw[:2] == b"\x1f\x8b":
            with gzip.open(BytesIO(raw)) as stream:
                # A guard against decompression bombs; one read would allocate the whole limit.
                blocks = iter(lambda: stream.read(MIB_BYTES), b"")
                raw = b"".join(islice(blocks, MAX_INVENTORY_BYTES // MIB_BYTES + 1))
            if len(raw) > MAX_INVENTORY_BYTES:
                size = f"{MAX_INVENTORY_BYTES // MIB_BYTES} MB"
                raise LipsyncError(f"{path}: unpacks to more than {size}; {mend}")
    except (EOFError, OSError, zlib.error):
        raise LipsyncError(f"{path}: is a broken gzip file; download it again") from None
    return utf8_text(path, raw)


def _inventories(text: str) -> Iterator[tuple[str, Inventory]]:
    """Yield (number, inventory) for every inventory with segments in a table."""
    comma = "\t" not in text.partition("\n")[0]
    # Tables with tabs hold quotation marks as they are; tables with commas quote cells.
    rows = csv.DictReader(
        text.splitlines(), delimiter="," if comma else "\t",
        quoting=csv.QUOTE_MINIMAL if comma else csv.QUOTE_NONE,
    )  # fmt: skip
    for number, members in grouped((_of(row, ID_COLUMNS), row) for row in rows).items():
        name, code = _of(members[0], NAME_COLUMNS), _of(members[0], CODE_COLUMNS)
        segments = tuple(dict.fromkeys(filter(None, (_of(row, SEGMENT) for row in members))))
        source = ", ".join(filter(None, (_of(members[0], SOURCE), name)))
        if segments:
            yield number, Inventory(f"PHOIBLE {number} ({source})", segments, name, code)


def _of(row: Mapping[str, str], names: tuple[str, ...]) -> str:
    return next((row[name] or "" for name in names if name in row), "").strip()


@dataclass(frozen=True)
class LanguageWish(PackWish):
    """Request for a new language, with at least one source of its sounds."""

    tag: str | None = None
    voice: str | None = None
    """eSpeak NG voice for transcription and speech."""
    epitran: str | None = None
    """Epitran code for transcription."""
    lexicon: Path | None = None
    """Path of a pronunciation lexicon for transcription."""
    profile: Path | None = None
    """Path of an orthography profile for transcription."""
    inventory: Path | None = None
    """Path of a phoneme inventory."""
    inventory_id: str | None = None
    texts: Sequence[str] = ()
    """Sample texts for the collection of labels."""


@dataclass
class FoundSounds:
    """The collected labels, with an example word if available."""

    words: dict[str, str] = field(default_factory=dict)
    spelled: dict[str, str] = field(default_factory=dict)

    def add(self, labels: Sequence[str], word: str = "") -> None:
        """Add the labels of a word; the first of equivalent spellings has precedence."""
        for stated in labels:
            # Engines mix compositions and look-alikes of one sound; a map would have it twice.
            label = self.spelled.setdefault(normalise(stated), stated)
            if not self.words.get(label):
                self.words[label] = word


@dataclass(frozen=True, eq=False)
class LanguageDraft(PackDraft):
    """A drafted language with its label counts; as text, a message with the next steps."""

    doubtful: int
    labels: int

    def __str__(self) -> str:
        wrote = "\n".join(f"wrote {path}" for path in self.outputs)
        return (
            f"{wrote}: {self.labels} labels, {self.doubtful} of them doubtful\n"
            f"next: check the doubtful labels, at the top of the map, and then run\n"
            f"  lipsync-lang languages show {self.path.stem}\n"
            f"  lipsync-lang validate {self.path}"
        )


def draft(library: Library, wanted: LanguageWish, folder: Path = Path()) -> LanguageDraft:
    """Draft a language pack, under `languages` of the project folder, or raise a LipsyncError."""
    path = folder / FOLDERS["language"] / f"{wanted.name}.yaml"
    check_name(wanted.name, path)
    if wanted.name in {found.name for found in library.names("language")}:
        raise PackError(f"there is a language '{wanted.name}' already; choose another name")
    _refuse(wanted)
    sounds, inventory = FoundSounds(), None
    if wanted.inventory is not None:
        inventory = read_inventory(wanted.inventory, wanted.inventory_id)
        sounds.add(inventory.segments)
    read = None
    if wanted.epitran:
        read = engine("epitran", Settings(wanted.name, code=wanted.epitran))
    elif wanted.voice and not (wanted.lexicon or wanted.profile):
        read = engine("espeak", Settings(wanted.name, voice=wanted.voice))
    for word in chain.from_iterable(read([*wanted.texts, *NUMBERS]) if read else ()):
        # Phrases and digits are unsuitable as example words.
        single = not any(map(str.isspace, word.text)) and not word.text.isdigit()
        sounds.add(word.labels, word.text if single else "")
    for spelling, labels in _spelled(wanted):
        sounds.add(labels, spelling)
    outputs: dict[Path, bytes | Path] = {}
    for beside in filter(None, (wanted.lexicon, wanted.profile)):
        copy = path.with_name(path.stem + beside.suffix)
        if copy.suffix.casefold() == path.suffix:  # many file systems ignore case
            raise LipsyncError(f"{beside}: has the suffix of a pack; give it another, such as .tsv")
        if copy.resolve() != beside.resolve():
            outputs[copy] = beside
    among = among_all(library)
    found = {label: among.nearest(label) for label in sounds.words}
    common = library.common().model
    mapped = {n for near in found.values() for n, _ in near.value}
    parents = {common.shades[n].like if n in common.shades else n for n in mapped}
    added, order = sorted(parents - {*common.base}), [*common.phonemes, *common.shades]
    tag = wanted.tag or (wanted.voice or "").partition("+")[0] or (wanted.epitran or "")[:3]
    tag = tag or (inventory.code if inventory else "")
    unseen = {normalise(label) for label, near in found.items() if not near.value}
    mute = [one for one in inventory.segments if normalise(one) in unseen] if inventory else []
    body = _mapped(sounds, found, order, common.usual.get(IPA, {}))
    known = {"wanted": wanted, "tag": tag, "adds": added, "inventory": inventory, "mute": mute}
    content = from_template("language", **known, **body).encode()
    doubtful = sum(map(_doubtful, found.values()))
    return LanguageDraft(path, {path: content} | outputs, doubtful, len(found))


def _spelled(wanted: LanguageWish) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield the words of a lexicon, and the sounds of a profile without a word, with the labels."""
    if wanted.lexicon is not None:
        yield from read_lexicon(wanted.lexicon).items()
    if wanted.profile is not None:
        yield from (("", labels) for labels in read_profile(wanted.profile).sounds.values())


def _refuse(wanted: LanguageWish) -> None:
    readers = {
        "--epitran": wanted.epitran, "--lexicon": wanted.lexicon, "--profile": wanted.profile,
    }  # fmt: skip
    given = [option for option, value in readers.items() if value]
    if not (given or wanted.voice or wanted.inventory):
        what = f"a new language needs a source: --voice, {', '.join(readers)} or --inventory"
        raise LipsyncError(what)
    if wanted.epitran and not wanted.texts:
        what = "Epitran has no list of its sounds; give sample lines for it to read: --text FILE"
        raise LipsyncError(what)
    if len(given) > 1:
        raise LipsyncError(f"{' and '.join(given)} read the same text; give only one of them")


def _doubtful(near: Nearest) -> bool:
    return near.distance > 0 or not near.value or bool(near.unknown)


def _mapped(
    sounds: FoundSounds,
    found: Mapping[str, Nearest],
    order: Sequence[str],
    usual: Mapping[str, Sounds],
) -> dict[str, object]:
    """Return the lines of the map and the examples, for the template.

    A label that is not doubtful is listed alone if its mapping is the usual one.
    """
    seen = [label for label, near in found.items() if near.value]
    doubtful = [label for label in seen if _doubtful(found[label])]
    doubtful.sort(key=lambda label: -found[label].distance)
    sure = [label for label in seen if not _doubtful(found[label])]
    sure.sort(key=lambda label: [order.index(name) for name, _ in found[label].value])
    alone = [one for one in sure if one in usual and usual[one].value == found[one].value]
    listed = " ".join(f"{as_scalar(label)}," for label in alone)
    lines = wrap(listed, LIST_WIDTH, initial_indent=" " * 4, subsequent_indent=" " * 4)
    lines += [_entry(label, found[label]) for label in sure if label not in alone]
    examples = {label: sounds.words[label] for label in (*doubtful, *sure)}
    return {
        "doubtful": [_entry(label, found[label]) for label in doubtful],
        "sure": lines,
        "examples": {label: word for label, word in examples.items() if word},
    }


def _entry(label: str, near: Nearest) -> str:
    names = [name for name, _ in near.value]
    shares = {round(share, 3) for _, share in near.value}
    value = names[0] if len(names) == 1 else f"[{', '.join(names)}]"
    if len(shares) > 1:
        parts = ", ".join(f"{share:.3g}" for _, share in near.value)
        value = f"{{to: {value}, shares: [{parts}]}}"
    told = [f"loses {', '.join(near.losses)}"] if near.losses else []
    told += [f"not IPA: {' '.join(near.unknown)}"] if near.unknown else []
    entry = f"    {as_scalar(label)}: {value},"
    return f"{entry:<19} # {'; '.join(told)}" if told else entry
