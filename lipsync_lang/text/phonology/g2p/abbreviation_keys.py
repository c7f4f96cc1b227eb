"""Keys of abbreviations and signs, found in a text and replaced by spoken words.

A key of an abbreviation is its spelling. `#` stands for a number, `##` for a number of two digits,
and so on, `~` for a Roman numeral, and `*` for the letters of a word; `{1}` in its expansion is the
first of them, and `{1:ordinal}` its word in the list `ordinal`. A space of a key may be missing in
the text, but for one between letters. An expansion with a full stop at its end ends a sentence
where a capital follows; others with a capital and a full stop are titles, which stand before a
name; the words after `|` serve without one. A key after `…` is the end of a word; one between two
of them stands within words, too. In the text, `#` is `№` here, the `~` of `~30` is `≈`, and digits
of other scripts are 0 to 9.
"""

import re
from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from functools import cache, cached_property, lru_cache
from itertools import chain, pairwise, product, starmap

from lipsync_lang.text.phonology.g2p.contexts import SEEN_LETTERS, Surroundings, compile_context
from lipsync_lang.text.phonology.g2p.number_words import DIGITS, number_words, roman
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import Replacement, counts, respelled

MAX_SCORE = 999
"""Maximum number of points in a score."""

SEEN_KEY_CHARS = 16
"""Number of characters examined on each side of an abbreviation."""

_UNSPACED_RANGES = "\u3040-\u30ff\u3400-\u9fff\uac00-\ud7af"
"""Characters of scripts that put no spaces between words, or are treated so."""

_UNSPACED_LETTER = re.compile("[\u0e00-\u0eff]")
"""A letter of a script that puts spaces between clauses, and none after an abbreviation."""

_SIGNS = str.maketrans("#\u2212٪٫٬״׳", "№-%.,\"'")
"""Signs of a text, and those of the keys that serve them."""

_SIGNED_DIGIT = rf"(?<![^\s(\[{{=<>~|«“„\"'、。，：；！？（「{_UNSPACED_RANGES}])-(?=\d)"
"""A minus; a hyphen behind a word, as in `F-16`, is none."""

_WAVE = re.compile(r"(?<=[\w%℃])[~～](?=\d)")
_RANGE_SIGN = re.compile(
    r"(?<=\d)[—－](?=\d)|(?:(?<=:\d\d)|(?<=\d[%€])|(?<=\d\s%))[-–—－](?=\d)"
    r"|(?<=\d)[-–](?=[$€£¥₩₹]\d)"
    r"|(?<=:\d\d )[-–—－](?= \d\d?:\d\d)"
)
"""A sign between two numbers that is neither a minus nor a hyphen, whatever else it is.

Keys with the sign itself precede those with `〜`."""
_ABOUT = re.compile("[~∼～](?= ?[0-9])")
_NUMBER_RUN = re.compile("-?[\\d., \u00a0\u202f]{1,40}\\D?")
"""A number with the sign behind it."""
_SIGN_BEHIND = re.compile("\\d[ \u00a0\u202f]?(\\D)")
_SIGN_OF_KEY = re.compile("[#\\d]+ ?([^#~* \\d])")
_FIRST_CHARS = {"#": "0123456789-", "~": "IVXLC"}
_NUMBER_PLACE = re.compile(r"\{(\d)(?::([\w-]+))?\}")
_BEFORE_ALONE = re.compile(r"([^{}]+)\{1\}")  # words before the only number: `max. 5 kg`
_BEFORE_LAST = re.compile(r"(\{1[^{}]*\})?([^{}]*)\{[12][^{}]*\}")
_CALL_SIGN = re.compile(r"(?<!\w)[^\W\d_]\w+ $")
"""The word before two digits that are read one by one, as in `Alpha 2-1`; it has a capital."""
_AFTER_INITIAL = re.compile(r"\.(?:[ \u00a0]?([^\W\d_])|\.)")
"""The rest of a name behind its initial; a speaker may break off."""
_LISTED_NUMBER = re.compile(r"\d+\.?")
_LISTED_RANGE = re.compile(
    r"(?<![A-Za-z\d.,:/–-])(\d{1,3}\.?)[-–〜](?=(\d{1,3})(?![\d–-]|[.,:/]\d))"
)
_SHARES = re.compile(r"(?<!\d)(\d+)/(\d+)$")
_OTHER_DIGIT = re.compile(r"(?![0-9])\d")
_NUMBER = re.compile(r"\d+(?:[.,]\d+)*")
_NUMBER_PATTERN = r"(\d{1,3}(?:[ \u00a0\u202f]\d{3})+(?!\d)(?:,\d+)?|\d+(?:[.,]\d+)*)"
"""A number; its thousands may have spaces between them."""
_SHOUTED = re.compile(r"[^\W\d_]{2,}|(?<!\d)[^\W\d_]")
_SPACES = " \u00a0\u202f"
_NO_DATE = re.compile(r"(?<![\d.])(?:0+\.\d+|\d+\.(?!0?[1-9]\.|1[0-2]\.)\d+)\.$")
"""A number before a full stop that has no day or no month, as in `Version 2.0.`."""
_LETTERS = r"([^\W\d_][^\s\d!-/:-@\[-`{-~]+)"
"""A letter and more, some of which may be marks on letters."""


class AbbreviationKeys:
    """Keys of abbreviations, looked up by the character that each begins with.

    An expression is compiled when a text has the beginning of its key: most texts have none.
    """

    def __init__(self, forms: SpokenForms) -> None:
        # engines name these signs where a pack has no words for them
        self._expansions = {"≈": " ", "/": " ", **forms.abbreviations}
        self._numbers = forms.numbers
        self._rules = {one: to for one, to in forms.numbers.items() if isinstance(to, Mapping)}
        bare = _NUMBER_PLACE.fullmatch(self._expansions.get("#", ""))
        self._bare = self._rules.get(bare[2] if bare else "")
        """Rules of every number in words, if the pack has any."""
        self._minus = self._expansions.get("-#", "").partition("{")[0]
        self._decimal, self._thousands = forms.decimal, forms.thousands
        # `van` of a name, and `ст.` of `тов. ст. л-т Серов`
        ranks = (rf"{re.escape(key)}(?!\w)" for key, to in forms.abbreviations.items() if "|" in to)
        particles = sorted((*map(re.escape, forms.particles), *ranks), key=len, reverse=True)
        self._particle = re.compile(f"(?:(?:{'|'.join(particles)}) ?){{,2}}")
        prefixes = "|".join(map(re.escape, forms.beginnings))
        # `ל` before an abbreviation such as `רס"ן`, which has a sign of its own
        self._prefix = re.compile(rf"(?<!\w)(?:{prefixes})$") if prefixes else None
        self._cases = [
            (Surroundings.compiled(before, after, "rank_cases"), endings)
            for before, after, endings in forms.rank_cases
        ]
        between = re.escape(forms.thousands) + _SPACES
        joins = "|".join(map(re.escape, forms.joins))
        item = r"\d\d?(?![^\W_]|[.:]\d)\.?"
        # `via Po 15, 4° piano` is no list
        listed = rf"(?<![\w.,:/-])(?:{item}(?:,|,? (?:{joins})) )*{item},? (?:{joins}) {item}"
        self._lists = joins and re.compile(listed)
        self._grouped = re.compile(
            rf"(?<!\d[{_SPACES}])(?:(?!0)\d{{1,3}}(?:[{between}]\d{{3}})+|\d\d?(?:,\d\d)+,\d{{3}})"
            rf"(?![{between}]?\d)"
        )
        self._beginnings: dict[tuple[str, str], dict[tuple[str, str], list[tuple[int, str]]]] = {}
        self._ends = {k.strip("…"): read for k, read in self._expansions.items() if k[0] == "…"}
        longest_first = sorted(self._expansions, key=lambda key: (-len(key), key.count("#"), key))
        for rank, key in enumerate(longest_first):
            literal = "" if key[0] in _FIRST_CHARS else re.split("[# ~*]", key[1:])[0]
            # most words like "in" have nothing of `in 19##` behind them
            follows = key[1 + len(literal) :].lstrip()[:1] if key[0] not in _FIRST_CHARS else ""
            # a number begins hundreds of keys, and the sign behind it few of them
            sign = _SIGN_OF_KEY.match(key)
            second = sign[1] if sign else literal[:1]
            for first in dict.fromkeys(_FIRST_CHARS.get(key[0]) or _either(key)):
                keys = self._beginnings.setdefault((first, second), {})
                keys.setdefault((literal, follows.strip("~*")), []).append((rank, key))
        read = _BEFORE_LAST.fullmatch(self._expansions.get("#〜#", ""))
        self._between = self._ends["〜"] = read[2] if read else ""
        self._starts = re.compile("|".join(self._start_patterns()))

    def _start_patterns(self) -> Iterator[str]:
        """Yield patterns of the places at which a key may begin."""
        for key in self._expansions:
            if key[0] == "…":
                # within `Ankara'da` and `10'da`, but not in `TSK'da`, which is spelled
                before = r"\w" if key[1].isalpha() else r"[^\WA-Z]"
                ends = (before, r"\d") if key[-1] == "…" else (r"[^\W\d_]", r"\w|[.,]\d")
                yield re.escape(key.strip("…")).join((f"(?<={ends[0]})", f"(?!{ends[1]})"))
        yield r"(?<!\d)(?<!\d[.,/:-])\d"
        yield _SIGNED_DIGIT
        firsts = dict.fromkeys(first for first, _ in self._beginnings)
        # most letters within words are passed over here, and the others one by one
        if letters := "".join(filter(str.isalpha, firsts)):
            yield f"(?<![A-Za-z])[{letters}]"
        # `½` is a sign, too
        signs = (one for one in firsts if not (one.isalpha() or one.isdecimal() or one == "-"))
        yield f"[{''.join(map(re.escape, signs))}]"
        if self._between:
            yield r"(?:(?<=[\w%€℃])|(?<=\d ))〜(?= ?[^\w\s]?\d)"

    def find(self, text: str) -> Iterator[Replacement]:
        """Yield the keys in a text with their expansions."""
        written = text
        at, text = 0, _ABOUT.sub("≈", _WAVE.sub("〜", text)).translate(_SIGNS)
        text = _OTHER_DIGIT.sub(lambda digit: str(int(digit[0])), text)
        plain = _RANGE_SIGN.sub("〜", text)
        # `12-Й`, `12. SZINT` and `12. STOCK` are read like small letters, but not `5G`
        ways = [_SHOUTED.sub(lambda word: word[0].lower(), text)] if text.isupper() else []
        ways += [_SHOUTED.sub(lambda word: word[0].capitalize(), one) for one in ways]
        calm = [one for one in ways if len(one) == len(text)]
        alike = {one.start: one for one in (*self._alike(text), *self._ranges(text))}
        while start := self._starts.search(plain, at):
            at = start.end()
            if start[0] in self._ends or start.start() in alike:
                said = Replacement(*start.span(), self._ends.get(start[0], ""))
                yield (said := alike.get(start.start(), said))
                at = said.stop
                continue
            pairs = {(one[at - 1], two) for one in (text, *calm) for two in (one[at : at + 1], "")}
            within = start[0].isalpha() and is_spaced(text[max(at - 2, 0) : at - 1])
            prefixed = self._prefix and self._prefix.search(text, max(at - 8, 0), at - 1)
            unknown = start[0].isalpha() and self._beginnings.keys().isdisjoint(pairs)
            if unknown or (within and not prefixed):
                continue
            fits = [self._match(one, start.start()) for one in dict.fromkeys((text, plain, *calm))]
            found, read = max(fits, key=lambda match: match[0].end() if match[0] else -1)
            if found and not (within and {*found[0]}.isdisjoint("\"'")):
                at, words = self._read(found, read)
                # the full stop of `12 lbs. and`, but not of a word that stays
                if text[at - 1].isalpha() and not words.endswith(text[at - 2 : at]):
                    at += text.startswith(". ", at) and text[at + 2 : at + 3].islower()
                yield Replacement(found.start(), at, words.lstrip() if within else words)
            elif grouped := self._grouped.match(text, start.start()):
                at = grouped.end()
                yield Replacement(*grouped.span(), re.sub(r"\D", "", grouped[0]))
            elif number := _NUMBER.match(text, start.start()):
                at = number.end()
                if number[0] != written[number.start() : at]:
                    yield Replacement(*number.span(), number[0])

    def _alike(self, text: str) -> Iterator[Replacement]:
        """Yield numbers of lists, such as `3., 5. und 9. Mai`, in the form of the last of each."""
        for listed in self._lists.finditer(text) if self._lists else ():
            before = text[max(listed.start() - SEEN_KEY_CHARS, 0) : listed.start()]
            after = text[listed.end() : listed.end() + 2 * SEEN_KEY_CHARS]
            *others, last = _LISTED_NUMBER.finditer(listed[0])
            found, form, rest, _ = self._form(before, last[0] + after)
            for one in others if found else ():
                same, own, *_ = self._form(before, one[0] + after)
                start = listed.start() + one.start()
                if same and own == form:
                    yield Replacement(start, start + len(one[0]), self._expanded(same, own).strip())
            # words before the list show the case of the last, too
            if found and found.start() < len(before):
                start = listed.start() + last.start()
                stop = start + found.end() - len(before)
                yield Replacement(start, stop, self._expanded(found, form + rest).lstrip())

    def _ranges(self, text: str) -> Iterator[Replacement]:
        """Yield ranges whose first number has the form of the last: `около 5-6 км`."""
        for ranged in _LISTED_RANGE.finditer(text):
            first, last = ranged.groups()
            if float(first) >= float(last):
                continue
            before = text[max(ranged.start() - SEEN_KEY_CHARS, 0) : ranged.start()]
            after = text[ranged.end(2) : ranged.end() + 2 * SEEN_KEY_CHARS]
            found, form, rest, lead = self._form(before, last + after)
            same, own, *_ = self._form(before, first + after)
            like = found if same and own == form else None
            start = ranged.start() - (len(before) - like.start() if like else 0)
            stated = self._match(text, start)[0]
            # a key of its own, such as `#-# {month}`
            if stated and stated.re.pattern not in _RANGE_PATTERNS and stated.lastindex != 1:
                continue
            if like and same:
                said = f"{self._expanded(like, lead)} {self._expanded(same, own).strip()}"
                said += (self._between or " ") + self._expanded(like, form + rest).lstrip()
                stop = ranged.end() + like.end() - len(before)
                yield Replacement(start, stop, " ".join(said.split()))
                continue
            # `2 минуты` has a key of its own, and `3 минуты` needs none
            alone, read = self._match(first + after, 0)
            if alone and (not alone.lastindex or alone.start(1)) and first != "1":
                said, _, noun = self._expanded(alone, read).rpartition(" ")
                if said and alone[0].endswith(noun):
                    said += (self._between or " ") + self.respelled(last)
                    yield Replacement(start, ranged.end(2), " ".join(said.split()))

    def _form(self, before: str, after: str) -> tuple[re.Match[str] | None, str, str, str]:
        """Return the match of a number after words, its form, what follows it and what leads."""
        starts = [*map(re.Match.start, re.finditer(r"\b\w", before)), len(before)]
        for found, read in (self._match(before + after, start) for start in starts):
            for place in range(1, 1 + (found.lastindex or 0)) if found else ():
                form = re.search(rf"[^ ]*\{{{place}(:?)[^ ]*", read)
                if found and form and form[1] and found.start(place) == len(before):
                    return found, form[0], read[form.end() :], read[: form.start()]
        return None, "", "", ""

    def _read(self, found: re.Match[str], read: str) -> tuple[int, str]:
        """Return the end and the words of a match; a unit after `3-5` is one of the last number."""
        # `60/40` as `50/50`, also in `al 60/40`, where a day and a month would have a key
        shares, halves = _SHARES.search(found[0]), self._expansions.get("50/50", "")
        if shares and "50" in halves and sum(map(int, shares.groups())) == 100:  # noqa: PLR2004 percent
            said = halves.replace("50", shares[1], 1).replace("50", shares[2])
            read = found[0][: shares.start()] + self.respelled(said)
        if found.re.pattern in _RANGE_PATTERNS:
            start, end = found.groups()
            # a range rises, but for `1914-18`, and a score such as `3-1` may fall
            if start.isdigit() and end.isdigit() and int(end) < int(start) <= MAX_SCORE:
                read = self._expansions.get("#:#", read)
            called = _CALL_SIGN.search(found.string, max(found.start() - 30, 0), found.start())
            if called and called[0][0].isupper() and len(start) == len(end) == 1 and start >= end:
                read = "{1} {2}"
        words = ""
        while found.re.pattern in _OPEN_PATTERNS and (before := _BEFORE_LAST.fullmatch(read)):
            first, last = found[1] if before[1] else "", found.lastindex or 0
            words += self.respelled(first) + before[2]
            match, read = self._match(found.string, found.start(last))
            if match is None:
                return found.end(), words + self.respelled(found[last])
            found = match
        if before := _BEFORE_ALONE.fullmatch(read):
            unit, after = self._match(found.string, found.start(1))
            # the number of `kl. 9.00.` ends before the zeros
            if unit and found.end(1) == found.end() == unit.end(unit.lastindex or 0) < unit.end():
                return unit.end(), words + before[1] + self._expanded(unit, after)
        return found.end(), words + self._expanded(found, read)

    def respelled(self, text: str) -> str:
        """Return a text with the expansions of its keys."""
        return respelled(text, self.find(text))

    def _match(self, text: str, at: int) -> tuple[re.Match[str] | None, str]:
        """Return the longest match of a key at a place of a text, and its expansion.

        The longer key precedes of two that match alike.
        """
        first = text[at]
        numeric = first.isdecimal() or first == "-"
        run = _NUMBER_RUN.match(text, at) if numeric else None
        behind = _SIGN_BEHIND.findall(run[0]) if run else ()
        fitting: list[tuple[int, str]] = []
        for second in {"", text[at + 1 : at + 2], *behind}:
            for (literal, follows), keys in self._beginnings.get((first, second), {}).items():
                end = at + 1 + len(literal)
                sign = text[end : end + 2].strip()[:1] if follows else ""
                if text.startswith(literal, at + 1) and (
                    sign == follows or (follows == "#" and sign.isdecimal())
                ):
                    fitting += keys
        best, read = None, ""
        for _, key in sorted(fitting):
            found = _expression(key).match(text, at)
            if not found or (best and found.end() <= best.end()):
                continue
            # the zeros of `9.00.` are minutes
            minutes = f" {key}"[-3:] in {" #.", ".#."} and _NO_DATE.search(found[0])
            initial = key.endswith(". ~") and self._before_initial(found, key[:-2])
            if minutes or initial or (key[0] == "~" and not roman(found[1])):
                continue
            in_word = is_spaced(key[-1]) or key[-1] in ".'"
            after = text[found.end() : found.end() + 2]
            # `les 2 m'ont vu`
            after = after.lstrip("'’") if key[-2:-1] == " " else after
            glued = key[-1] == "." and _UNSPACED_LETTER.match(after)
            titled, choosy, alone = self._expansions[key].partition("|")
            rank, alone = alone.startswith("|"), alone.lstrip("|")
            particle = self._particle if choosy else None
            fits = _fits(found, titled, particle, "!?,;" if rank and key[-1] == "." else "")
            # the full stop of `por. idzie` ends no sentence
            goes_on = key[2:].endswith(".") and after[:1] in _SPACES and after[1:].islower()
            case = self._case(found, named=fits) if rank or (fits and choosy) else None
            shown = goes_on or case is not None
            nameless = rank and not fits and (alone == titled or (not alone and shown))
            words = _inflected(titled, case or {}) if fits or nameless else alone
            words += "." * (nameless and not goes_on and key[-1] == ".")
            if words and (glued or not (in_word and is_spaced(after[:1]))):
                best, read = found, words
        return best, read

    def _before_initial(self, found: re.Match[str], title: str) -> bool:
        """Return True before the `L` of `Cap. L. Ramos`; few books have fifty chapters."""
        initial = found[1] in {"L", "C"} or "|" in self._expansions.get(title, "")
        name = _AFTER_INITIAL.match(_seen_after(found)) if initial and len(found[1]) == 1 else None
        return name is not None and not (name[1] or "").islower()

    def _case(self, found: re.Match[str], *, named: bool) -> Mapping[str, str] | None:
        """Return the endings of the first case that the text around a rank shows."""
        text, start = found.string, found.start()
        name = found.end() + (_seen_after(found)[:1] in {*_SPACES}) if named else len(text)
        return next((ends for around, ends in self._cases if around.fit(text, start, name)), None)

    def _expanded(self, found: re.Match[str], read: str) -> str:
        """Return the expansion of a key with its numbers, and spaces before and after words."""

        def number(place: re.Match[str]) -> str:
            written, words = found[int(place[1])], self._numbers.get(place[2] or "", ())
            if re.fullmatch(r"\d+[-–]\d+", written) and {*words} != DIGITS:
                return self.respelled(written)
            written = written.lstrip("-") if self._minus else written
            if self._bare and not words and written != found[0] and written[-1].isdigit():
                # decimals are read as their key says
                return self.respelled(written)
            written = self._grouped.sub(lambda one: re.sub(r"\D", "", one[0]), written)
            if self._thousands == ",":
                written = written.replace(",", ", ")  # two numbers, such as `2,3`
            if isinstance(words, Mapping):
                written = str(roman(written) or written.lstrip("-"))
                return number_words(words, written, self._rules, self._decimal)
            value = int(written) if written.isdigit() else roman(written)
            if 0 < value <= len(words):
                return words[value - 1]
            if written.isalpha():
                return str(value) if value else written
            return re.sub("[.,]", f" {self._decimal} ", written) if self._decimal else written

        negative = found.lastindex and found[1].startswith("-")
        read = self._minus * bool(negative) + _NUMBER_PLACE.sub(number, read)
        if self._bare:
            # `{few} km` of a list of digits
            read = number_words(self._bare, read, self._rules, self._decimal)
        rest = _seen_after(found)
        if read.endswith(".") and rest.strip() and not rest.lstrip()[:1].isupper():
            read = read[:-1]
        before = found.string[max(found.start() - 1, 0) : found.start()]
        # the sign of `20 €/h` has become words
        beside = any(map(counts, before)) or found[0][0] == "/"
        left = " " if beside and read[:1].isalnum() else ""
        right = " " if is_spaced(rest[:1]) and counts(read[-1:] or " ") else ""
        return left + read + right


def _inflected(rank: str, endings: Mapping[str, str]) -> str:
    """Return a rank with the endings of a case, the longest first."""
    return " ".join(
        next((w[:at] + endings[w[at:]] for at in range(len(w)) if w[at:] in endings), w)
        for w in rank.split(" ")
    )


@lru_cache(10_000)
def is_spaced(char: str) -> bool:
    """Return True for a letter, mark or digit of a script that puts spaces between words."""
    return not re.match(f"[{_UNSPACED_RANGES}]", char) and any(map(counts, char))


def _either(key: str) -> str:
    """Return the first letter of a key; that of a word may be a capital, as in a sentence."""
    # `x3` is no `BMW X3`, and `u. ` no `U. Thurman`
    capital = key[0].upper() if key[0].islower() and key[1:2] != "#" and key[1:] != ". " else ""
    return key[0] + (capital if len(capital) == 1 else "")


def _fits(found: re.Match[str], read: str, particle: re.Pattern[str] | None, ends: str) -> bool:
    """Return False for a title without a name: `vitamin D.`, `in Main St.`, `5 m. wide`.

    Behind a title that may mean something else, a name has a capital, perhaps after a `particle`.
    One of the marks `ends` behind a rank is enough: `mon cap. !`.
    """
    key = found[0]
    if read.endswith(".") or not (particle or key.endswith(".")):
        return True
    after = _seen_after(found).lstrip(" \u00a0\u202f")
    if re.fullmatch(r"[\d. ]+", key):
        goes_on = _seen_after(found)[:1] in _SPACES and after[:1].islower()
        return goes_on or after[:1] in {*",;?!"}
    if found.lastindex:
        return True
    if len(key) == len("D."):
        before = found.string[max(found.start() - SEEN_KEY_CHARS, 0) : found.start()].rstrip()
        return after[:1].isalpha() and not after[:1].islower() and not before[-1:].isdigit()
    if particle:
        behind = after[:1] + particle.sub("", after, count=1)[:1]
        return any(one.isupper() or one in ends for one in behind)
    return any(map(str.isalnum, after[:3])) or not key[0].isupper()


def _seen_after(found: re.Match[str]) -> str:
    """Return the start of the text after a match; the whole rest would be copied for each match."""
    return found.string[found.end() : found.end() + SEEN_KEY_CHARS]


@cache
def _expression(key: str) -> re.Pattern[str]:
    """Return the expression of a key; spaces in it may be missing in a text."""
    # a space between letters parts two words: `на с.` is no `нас.`
    key = re.sub(r"(?<=[^\W\d_]) (?=[^\W\d_])", "\0", key)
    parts = [
        (_NUMBER_PATTERN if part == "#" else rf"(\d{{{len(part)}}})")
        if part.startswith("#")
        else f"[{_SPACES}]" + "?" * (part == " ")
        if part in " \0"
        else _LETTERS
        if part == "*"
        # "Le" and "Ce" are words, and no numerals with an ending
        else ("([IVX]{1,6})" if after.isalpha() else r"([IVXLC]{1,7})(?![^\W\d_])")
        if part == "~"
        else re.escape(part)
        for part, after in pairwise([*re.findall("#+|[^#]", key), ""])
    ]
    if "#.# " in key:
        # `1.000 km` are a thousand
        parts = [r"\.(?!\d{3}(?!\d))" if part == r"\." else part for part in parts]
    if key[0].isalpha():
        parts[0] = f"[{_either(key)}]"
    elif key[:1] == "#" != key[1:2]:
        parts[0] = f"(-?(?:{parts[0][1:]})"
    if key[0].isalpha() and key[-1] == "#":
        # `pages 12–15`, and `February 2nd`
        parts[-1] = parts[-1][:-1] + r"(?:[-–]\d+)?)"
        parts.append("(?![a-z])")
    if key[-1] == "#" or key[-1].isdigit():
        parts.append(r"(?!\d|[.,/:–-]\d|\.?[ºª])")
    return re.compile("".join(parts))


_RANGE_KEYS = ("#-#", "# - #", "#–#", "#—#", "#〜#")
_RANGE_PATTERNS = frozenset(_expression(key).pattern for key in _RANGE_KEYS)
_OPEN_KEYS = (*_RANGE_KEYS, "# x #", "# × #", "≈ #", "± #", "= #", "-#")
_OPEN_PATTERNS = frozenset(_expression(key).pattern for key in _OPEN_KEYS)
"""Keys whose last number may have a unit behind it."""

_DOT = r"(?P<dot>\.(?= +[^\W\d_A-ZÀ-Þ]))?"
"""The full stop of an ordinal number, as in `Karl V. war`."""

_LATIN_LETTERS = "A-Za-zÀ-ɏḀ-ỿ"
_AFTER_NAME = re.compile(
    rf"(?<![^\W\d_])[^\W\d_]+[ \u00a0]+(?P<numeral>[IVX]{{2,7}})(?![{_LATIN_LETTERS}\d])" + _DOT
)
_AFTER_OTHER_NAME = re.compile(r"(?<!\w)[Ά-ΩЀ-Я][ά-ώа-џґ]+ (?P<numeral>[IVX]{1,7})(?!\w)" + _DOT)
"""A name in other letters, where no numeral is a word or a letter."""
_BEFORE_WORD = re.compile(
    r"(?<!\w)(?P<word>\w+ |)(?P<shape>(?P<numeral>[IVX]{2,7})(?P<dot>\.?))(?= [^\W\d_]{2})"
)
_NEXT_WORD = re.compile(r"\s+([a-z]\w*)")
_NUMERAL_LETTERS = re.compile(r"[IVXLCDM]+(?![a-z])")
_CAPITALS = re.compile(
    rf"(?<![{_LATIN_LETTERS}])(?![A-Z]+([A-Z])\1)[A-Z]{{1,5}}(?![{_LATIN_LETTERS}'’])"
)
"""Capitals of an abbreviation; sounds are none, such as `PSST` and `GRRR`."""

_SYLLABLES = re.compile("vv.*|(?=....)c?(?:vv?c)+v{,2}")
"""Two vowels, as in `AAH` and `OI`, or a vowel beside each consonant, as in `SALE` and `TIDAK`."""

_RUBY_TEXT = re.compile(
    "(?:[｜|](?P<marked>[^｜|《》\n]{1,40})|(?P<hanzi>[\u3400-\u9fff々〆ヶ]{1,40}))"
    "《(?P<reading>[ぁ-ゖァ-ヺー・]{1,60})》"
)
"""A word with its reading in kana, as in 漢字《かんじ》; of several hanzi, all in a row."""

_KATAKANA = {code: code + 0x60 for code in range(0x3041, 0x3097)}
"""Katakana cannot be mistaken for a particle, as は and へ can."""


class Expansions:
    """A finder of abbreviations, signs, Roman numerals and ruby of a language."""

    def __init__(self, forms: SpokenForms) -> None:
        self._forms = forms

    def find(self, text: str) -> list[Replacement]:
        """Return what to replace in a text, in order and apart from each other."""
        found: list[Replacement] = []
        ruby = (
            Replacement(*one.span(), one["reading"].translate(_KATAKANA))
            for one in (_RUBY_TEXT.finditer(text) if "《" in text else ())
        )
        rows = ruby, self._again(text), self._keys.find(text), self._roman(text)
        replaced = chain(*rows, self._before_word(text), self._spelled(text))
        for one in sorted(replaced, key=lambda one: (one.start, -one.stop)):
            if not found or one.start >= found[-1].stop:
                found.append(one)
        return found

    @cached_property
    def _keys(self) -> AbbreviationKeys:
        return AbbreviationKeys(self._forms)

    def _spelled(self, text: str) -> Iterator[Replacement]:
        """Yield capitals in a row as the names of their letters.

        Those that could be syllables are words, and in a sentence that is all capitals, those with
        any vowel: `AYO KITA PERGI!`.
        """
        names, vowels = self._forms.letters, self._forms.vowels
        for sentence in re.finditer("[^.!?…\n]+", text) if names else ():
            shouted = all(map(str.isupper, filter(str.isalpha, sentence[0])))
            for one in _CAPITALS.finditer(text, *sentence.span()):
                known = one[0].lower() in self._forms.interjections or one[0] in self._forms.words
                shape = "".join("cv"[letter in vowels] for letter in one[0].lower())
                word = known or ("v" in shape if shouted else _SYLLABLES.fullmatch(shape))
                if not word and names.keys() >= set(one[0]):
                    yield Replacement(*one.span(), " ".join(names[letter] for letter in one[0]))

    def _again(self, text: str) -> Iterator[Replacement]:
        """Yield the word before each sign of repetition in place of the sign."""
        for sign, repeated in self._forms.repeated.items():
            before = compile_context(repeated, precedes=True).pattern
            for one in re.finditer(rf"{re.escape(sign)}(?!\d)", text):
                if said := before.search(text, max(0, one.start() - SEEN_LETTERS), one.start()):
                    yield Replacement(*one.span(), f" {said[0]} ")

    def _roman(self, text: str) -> Iterator[Replacement]:
        for pattern, ordinals in self._numerals if _NUMERAL_LETTERS.search(text) else ():
            bare = pattern in (_AFTER_NAME, _AFTER_OTHER_NAME)
            for one in pattern.finditer(text):
                before = text[max(one.start() - SEEN_KEY_CHARS, 0) : one.start()]
                after = text[one.end("numeral") : one.end("numeral") + 1]
                numeral, words = one["numeral"], self._forms.numeral_words
                like = bare and one[0].replace(numeral, "~").lower() in self._forms.numerals_like
                number = roman(numeral)
                ordinal = 0 < number <= len(ordinals)
                read = ordinals[number - 1] if ordinal else self._keys.respelled(str(number))
                next_word = _NEXT_WORD.match(text, one.end("numeral")) if numeral in words else None
                first = "^" * (not before.rstrip(' "“«([')[-1:].strip(".!?…:"))
                said = {next_word[1], first + next_word[1]} if next_word else set()
                after_all = any(starmap(fnmatchcase, product(said, words.get(numeral) or ())))
                other = one[0][0].islower() if bare else is_spaced(before[-1:]) or is_spaced(after)
                if number and not ((said and not after_all) or like or other):
                    yield Replacement(one.start("numeral"), one.end(), read)

    def _before_word(self, text: str) -> Iterator[Replacement]:
        """Yield Roman numerals before a word, read as digits are in their place: `II. Stock`."""
        likes = self._forms.numerals_like
        for one in _BEFORE_WORD.finditer(text) if likes else ():
            (start, stop), word, shape = one.span("shape"), one["word"], f"~{one['dot']}"
            # `Otto II. Der` is a name, and `Der II. Stock` is none
            name = word[4:] and not word[0].islower()
            like = likes.get(word.lower() + shape) or likes.get("" if name else shape, "")
            digits = like.replace("#", str(roman(one["numeral"]) or ""))
            for found in self._keys.find(text[:start] + digits + text[stop:]) if like else ():
                if found.start <= start < found.stop:
                    yield found._replace(stop=found.stop + stop - start - len(digits))

    @cached_property
    def _numerals(self) -> list[tuple[re.Pattern[str], tuple[str, ...]]]:
        """Expressions for Roman numerals, and the ordinal numbers that replace them."""
        forms = self._forms
        numeral = r"(?P<numeral>[IVXLCDM]{1,12})(?![A-Za-z'’])"
        found: list[tuple[re.Pattern[str], tuple[str, ...]]] = []
        for words, ordinals in ((forms.named, forms.ordinals), (forms.counted, ())):
            if known := "|".join(map(re.escape, sorted(words, key=len, reverse=True))):
                known = known.replace(r"\*", r"[^\W\d_]+[ \u00a0]")
                known = rf"(?<![A-Za-z])(?i:{known})[ \u00a0]*{numeral}{_DOT}"
                found.append((re.compile(known), ordinals))
        return [*found, (_AFTER_OTHER_NAME, forms.ordinals), (_AFTER_NAME, ())] if found else []
