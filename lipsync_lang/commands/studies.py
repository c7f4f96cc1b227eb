"""Commands that make a study and collect its answers."""

import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.commands.output import FAULTS, SOUND, as_json, count
from lipsync_lang.commands.script_options import cleaning
from lipsync_lang.errors import LipsyncError
from lipsync_lang.terminal import progress, wipe

if TYPE_CHECKING:
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.study.methods import Method, StudyCharacter
    from lipsync_lang.study.study_lines import StudyLine
    from lipsync_lang.study.study_maker import MadeStudy, StudyPlan
    from lipsync_lang.study.study_page import PageTexts

MAX_CONSENT_BYTES = 100_000
"""Size limit in bytes of a consent text."""

MAX_PAGE_BYTES = 60 * 10**6
"""Size of a page in bytes above which a phone may refuse it."""


def new(options: Namespace) -> int:
    """Render the clips of a study, and write its key and its page."""
    from lipsync_lang.study.study_maker import KEY, PAGE, make_study

    plan = _plan(options)
    try:
        made = make_study(plan, options.output, workers=options.workers, told=_told)
    finally:
        wipe()
    key, page = options.output / KEY, options.output / PAGE
    if options.json:
        print(as_json(_as_data(made)))
    print(_summary(made), file=sys.stderr)
    print(f"wrote {key} for you and {page} for raters", file=sys.stderr)
    return FAULTS if made.remarks else SOUND


def _told(what: str, done: int, of: int) -> None:
    progress(f"{what} {done} of {of} ...")


def _as_data(made: "MadeStudy") -> dict[str, object]:
    return {
        "study": made.study.study,
        "pairs": len(made.study.pairs),
        "checks": sum(pair.check is not None for pair in made.study.pairs),
        "rendered": made.rendered,
        "page_bytes": made.page_bytes,
        "left_out": made.remarks,
    }


def _summary(made: "MadeStudy") -> str:
    checks = sum(pair.check is not None for pair in made.study.pairs)
    pairs = count(len(made.study.pairs) - checks, "pair")
    told = (
        f"{pairs}, {count(checks, 'attention check')}, "
        f"{count(made.rendered, 'clip')} rendered, page of {made.page_bytes / 1e6:.1f} MB"
    )
    if made.page_bytes > MAX_PAGE_BYTES:
        told += f"\nthe page is larger than {MAX_PAGE_BYTES // 10**6} MB; give fewer --pairs"
    return "\n".join((told, *made.remarks))


def _plan(options: Namespace) -> "StudyPlan":
    from lipsync_lang.study.methods import parse_methods
    from lipsync_lang.study.study_maker import StudyPlan

    methods = parse_methods(options.method)
    return StudyPlan(
        _lines(options),
        tuple(_cast(options, name) for name in dict.fromkeys(options.character)),
        methods,
        options.title,
        _texts(options),
        tuple(dict.fromkeys(options.question)) or StudyPlan.questions,
        options.pairs,
        options.checks,
        options.raters_see,
        options.seed,
        options.tts,
    )


def _lines(options: Namespace) -> "tuple[StudyLine, ...]":
    from lipsync_lang.lines import read_lines
    from lipsync_lang.study.study_lines import study_lines

    def remark(text: str) -> None:
        print(text, file=sys.stderr)

    found = read_lines(
        options.lines,
        column=options.column,
        encoding=options.encoding,
        remark=remark,
        cleaning=cleaning(options),
    )
    return study_lines(found, options.text, options.audio, remark)


def _texts(options: Namespace) -> "PageTexts":
    from lipsync_lang.files import read_input
    from lipsync_lang.study.study_page import CONSENT, PageTexts, parse_asked

    consent = CONSENT
    if options.consent is not None:
        content = read_input(options.consent, MAX_CONSENT_BYTES, mend="shorten it")
        try:
            consent = content.decode("utf-8-sig").replace("\r\n", "\n")
        except UnicodeDecodeError as error:
            raise LipsyncError(
                f"{options.consent}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
            ) from None
    return PageTexts(consent, tuple(map(parse_asked, options.ask)), options.post)


def _cast(options: Namespace, name: str) -> "StudyCharacter":
    """Return a character with its performers for the methods."""
    from dataclasses import replace

    from lipsync_lang.commands.performing import motion_settings
    from lipsync_lang.performing.resolving import resolve as resolve_pair
    from lipsync_lang.study.methods import StudyCharacter, with_bank

    def resolved(character: str | Path) -> "Performer":
        performer = resolve_pair(
            options.language,
            character,
            paths=options.path,
            motion=motion_settings(options.settings),
        )
        return replace(performer, cleaning=cleaning(options))

    own = resolved(name)

    def other(method: "Method") -> "Performer":
        if method.how == "motion":
            return own.with_motion(method.what)
        if method.how == "character":
            return resolved(method.what)
        return with_bank(own, name, Path(method.what), resolved)

    model = options.model or own.model
    if model is None:
        raise LipsyncError(f"{name} has no model to film; name one with --model GLB")
    return StudyCharacter(own, model, other, options.fps)


def serve(options: Namespace) -> int:
    """Serve a study's page and append the answers to a file, until it is interrupted."""
    from contextlib import suppress

    from lipsync_lang.study.answer_server import answer_server

    with answer_server(options.folder, options.host, options.port, options.origin) as server:
        port = server.server_address[1]
        host = f"[{options.host}]" if ":" in options.host else options.host
        print(f"the study is at http://{host}:{port}/", flush=True)
        print(f"answers are appended to {server.answers}; close with Ctrl-C", file=sys.stderr)
        with suppress(KeyboardInterrupt):  # the usual end of a server
            server.serve_forever(poll_interval=0.2)
    return SOUND
