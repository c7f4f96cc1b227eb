"""Put drafts where a person can edit them: as YAML, into a bank file."""

from dataclasses import dataclass
from pathlib import Path

from lipsync_lang.errors import OutputError, PackError

Points = list[list[float]]


@dataclass(frozen=True)
class Drafts:
    """Drafted bigrams of one pose set, ready to be written."""

    poseset: str
    bigrams: dict[str, dict[str, Points]]
    """For each bigram, such as `l-ow`, control points by pose."""


def draft_yaml(drafts: Drafts) -> str:
    """Return drafts as the text of a bank's `bigrams`."""
    if not drafts.bigrams:
        return "bigrams: {}\n"
    lines = ["bigrams:"]
    for key, curves in drafts.bigrams.items():
        lines += [f"  {key}:", "    status: drafted", "    curves:" + ("" if curves else " {}")]
        width = max(map(len, curves), default=0) + 1
        lines += [f"      {pose + ':':<{width}} {_flow(points)}" for pose, points in curves.items()]
    return "\n".join(lines) + "\n"


def _flow(points: Points) -> str:
    return "[" + ", ".join(f"[{t:g}, {v:g}]" for t, v in points) + "]"


def write_drafts(drafts: Drafts, path: Path | None = None) -> str:
    """Add drafts to a bank file, leaving every bigram that is there as it is.

    Parameters
    ----------
    path : the bank; None is `common.yaml` of the pose set in the project's own folder

    Returns
    -------
    What was done, in a line
    """
    from ruamel.yaml.comments import CommentedMap

    from lipsync_lang.packs.edit import edit_pack, flow

    if path is None:
        path = Path("posesets") / drafts.poseset / "banks" / "common.yaml"
    new: list[str] = []

    def add(bank: CommentedMap) -> None:
        _refuse_other(path, bank, drafts.poseset)
        bigrams = bank.get("bigrams") or CommentedMap()
        for key, curves in drafts.bigrams.items():
            if key not in bigrams:
                lines = CommentedMap((pose, flow(_plain(p))) for pose, p in curves.items())
                bigrams[key] = CommentedMap(status="drafted", curves=lines)
                new.append(key)
        bigrams.fa.set_block_style()
        bank["bigrams"] = bigrams

    if path.suffix != ".yaml":
        raise OutputError(f"{path}: is no name for a bank; end it in .yaml")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = error.strerror or error
        raise OutputError(f"{path.parent}: cannot be made: {why}; name another place") from None
    edit_pack(path, add, create=_empty_bank(drafts.poseset, path))
    kept = len(drafts.bigrams) - len(new)
    stay = "was there already and stays as it is"
    if kept > 1:
        stay = "were there already and stay as they are"
    there = f"; {kept} {stay}" if kept else ""
    return f"{len(new)} drafted bigram{'' if len(new) == 1 else 's'} put into {path}{there}"


def _refuse_other(path: Path, bank: object, poseset: str) -> None:
    """Raise where a file is something else than a bank of a pose set."""
    stated = bank if isinstance(bank, dict) else {}
    if (stated.get("kind"), stated.get("poseset")) != ("bank", poseset):
        raise PackError(f"{path}: is not a bank of {poseset}; name another file for the drafts")
    if not isinstance(stated.get("bigrams") or {}, dict):
        raise PackError(f"{path}: its bigrams are no mapping; write `bigrams: {{}}` there")


def _plain(points: Points) -> list[list[float]]:
    """Write 0 and 1 as people do."""
    return [[int(n) if n == int(n) else n for n in point] for point in points]


def _empty_bank(poseset: str, path: Path) -> str:
    return (
        "# Bigrams that a person edited or approved; all others are drafted from the targets.\n"
        f"kind: bank\nformat: 1\nname: {path.stem}\nposeset: {poseset}\nlanguage: null\n"
        "style: neutral\ninterpolation: bspline\nbigrams: {}\n"
    )
