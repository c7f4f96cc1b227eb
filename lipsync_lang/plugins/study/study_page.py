"""Page of a study: a file with all clips, which asks for, keeps and exports answers.

The page has no key: pairs have numbers, clips have sides, and no method is named. Text is data,
never markup; the policy of the page allows only its own script and style, by their hashes, and
requests to the address for answers.
"""

import json
from base64 import b64encode
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib.resources import files
from typing import Any
from urllib.parse import urlsplit

from lipsync_lang import LipsyncError
from lipsync_lang.plugins.study.study_clips import of_one_size
from lipsync_lang.plugins.study.study_file import QUESTIONS, Study

UNPOSTED = b'{"post":null,'
"""Start of the data of a page without an address for answers; a server adds its own."""

MAX_CONSENT_CHARS = 20_000

MAX_ASKED = 20
"""Maximum number of questions about the rater."""

MAX_KEY_CHARS = 40

DEFINITIONS = {
    "accuracy": {
        "ask": "Which mouth is more accurate?",
        "means": "Accurate: the mouth moves in step with the words that you hear. The more "
        "accurate it is, the more you could understand by reading the lips without sound.",
    },
    "naturalness": {
        "ask": "Which mouth is more natural?",
        "means": "Natural: the mouth moves like that of a human who speaks.",
    },
}
"""Questions as raters read them, after section 4.1 of the paper."""

CONSENT = (
    "You will see pairs of short clips in which a face speaks, and choose the better one of each. "
    "Please use headphones or a loudspeaker.\n\n"
    "Taking part is voluntary, and you may stop at any time. The page records your choices, the "
    "time of each choice, a random number, and your answers to the questions on this page. It "
    "records nothing else about you or your device. Answers stay in this browser until you send or "
    "save them."
)


@dataclass(frozen=True)
class AskedQuestion:
    """A question about the rater, with its choices."""

    key: str
    label: str
    choices: tuple[str, ...]
    """Choices of a list; empty for free text."""


def parse_asked(text: str) -> AskedQuestion:
    """Parse a question about the rater.

    >>> parse_asked("Age group: 18-30|31-50|51+")
    AskedQuestion(key='age_group', label='Age group', choices=('18-30', '31-50', '51+'))

    Raises LipsyncError if the question has no text.
    """
    label, _, rest = text.partition(":")
    key = "_".join("".join(c if c.isalnum() else " " for c in label.lower()).split())
    choices = tuple(choice.strip() for choice in rest.split("|") if choice.strip())
    if not key:
        raise LipsyncError(f"question '{text}': write it as 'Age group: 18-30|31-50|51+'")
    return AskedQuestion(key[:MAX_KEY_CHARS], label.strip(), choices)


@dataclass(frozen=True)
class PageTexts:
    """Texts of a page, and its address for answers."""

    consent: str = CONSENT
    asked: tuple[AskedQuestion, ...] = ()
    post: str | None = None
    """Address for answers; None to save them as files."""

    def refuse_faults(self) -> None:
        """Refuse a consent text, questions or an address that a page cannot have."""
        if not self.consent.strip() or len(self.consent) > MAX_CONSENT_CHARS:
            what = f"the consent text must have between 1 and {MAX_CONSENT_CHARS} characters"
            raise LipsyncError(what)
        keys = [one.key for one in self.asked]
        if len(set(keys)) < len(keys) or len(keys) > MAX_ASKED:
            raise LipsyncError(f"ask at most {MAX_ASKED} questions, and each only once (`ask`)")
        if self.post is not None:
            origin_of(self.post)


def origin_of(address: str) -> str:
    """Return the origin of a web address, such as ``https://example.org``; refuse others."""
    try:
        parts = urlsplit(address)
        port = f":{parts.port}" if parts.port else ""
        host = parts.hostname or ""
    except ValueError:
        parts, port, host = urlsplit(""), "", ""
    plain = host.isascii() and host.replace("-", "").replace(".", "").isalnum()
    if parts.scheme not in {"http", "https"} or not plain or parts.username is not None:
        what = "is not a web address; give one such as https://example.org/answers"
        raise LipsyncError(f"{address}: {what}")
    return f"{parts.scheme}://{host}{port}"


def study_page(
    study: Study, texts: PageTexts, clips: Callable[[str], Sequence[bytes]]
) -> Iterator[str]:
    """Yield the parts of a page; `clips` gives the MP4 files of a pair, left and right."""
    texts.refuse_faults()
    script, style = _static("answering.js"), _static("answering.css")
    hashes = [b64encode(sha256(text.encode()).digest()).decode() for text in (script, style)]
    allowed = "'self'" if texts.post is None else origin_of(texts.post)
    document = json.dumps(_document(study, texts), separators=(",", ":"), ensure_ascii=False)
    parts = {
        "POLICY": f"default-src 'none'; script-src 'sha256-{hashes[0]}'; "
        f"style-src 'sha256-{hashes[1]}'; media-src blob:; connect-src {allowed}; "
        "img-src data:; base-uri 'none'; form-action 'none'",
        "STYLE": style,
        "SCRIPT": script,
        "DOCUMENT": document.replace("<", "\\u003c"),
    }
    # In parts instead of one text: a page of 60 MB would be in memory several times.
    head, *rest = _static("answering.html").split("{{")
    yield head
    for part in rest:
        name, _, after = part.partition("}}")
        if name == "CLIPS":
            for pair in study.pairs:
                films = of_one_size(clips(pair.pair))
                for side, film in zip(("left", "right"), films, strict=True):
                    text = b64encode(film).decode()
                    yield f'<script type="text/plain" id="{pair.pair}-{side}">{text}</script>\n'
        else:
            yield parts[name]
        yield after


def _static(name: str) -> str:
    return (files("lipsync_lang.plugins.study") / "static" / name).read_text("utf-8")


def _document(study: Study, texts: PageTexts) -> dict[str, Any]:
    names = [pair.pair for pair in study.pairs]
    checks = [pair.pair for pair in study.pairs if pair.check]
    groups = [{"take": len(names), "pairs": names}]
    if study.raters_see is not None and study.raters_see < len(names):
        # A rater who sees a part of the pairs sees every attention check.
        others = [name for name in names if name not in set(checks)]
        some = ((checks, len(checks)), (others, max(1, study.raters_see - len(checks))))
        groups = [{"take": take, "pairs": group} for group, take in some if group]
    return {
        "post": texts.post,
        "study": study.study,
        "title": study.title,
        "consent": [part for part in texts.consent.split("\n\n") if part.strip()],
        "asked": [asdict(one) for one in texts.asked],
        "questions": [
            {"key": key, **DEFINITIONS[key]} for key in QUESTIONS if key in study.questions
        ],
        "groups": groups,
    }
