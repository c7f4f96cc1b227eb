"""Studies and answers for tests: raters with a stated taste, and files of them."""

import json
import random

from lipsync_lang.plugins.study.study_file import Study, Submission, parsed, texts_of

STUDY = "0123456789abcdef"


def study_of(  # noqa: PLR0913 a study has many parts
    methods=("ours", "theirs"),
    characters=("anna",),
    lines=20,
    *,
    questions=("accuracy",),
    checks=0,
    seconds=2.0,
    seed=1,
):
    """Return a study of all pairs of methods on each line and character, with random sides."""
    chance = random.Random(seed)  # noqa: S311 no secret
    pairs = []

    def add(line, character, sides, check=None):
        pairs.append(
            {
                "pair": f"p{len(pairs) + 1:03}",
                "line": line,
                "character": character,
                "left": sides[0],
                "right": sides[1],
                "check": check,
                "seconds": seconds,
            }
        )

    for character in characters:
        for number in range(lines):
            for place, first in enumerate(methods):
                for second in methods[place + 1 :]:
                    sides = [first, second]
                    chance.shuffle(sides)
                    add(f"line_{number:02}", character, sides)
    for number in range(checks):
        add(f"check_{number}", characters[0], methods[:2], chance.choice(("left", "right")))
    return {
        "kind": "study",
        "format": 1,
        "study": STUDY,
        "title": "A study",
        "seed": seed,
        "questions": list(questions),
        "methods": list(methods),
        "raters_see": None,
        "pairs": pairs,
        "asked": [],
    }


def submission(study, number, chooses, *, strength=3, seconds=6.0):
    """Return the answers of a rater who takes the left clip if `chooses(pair, question)`."""
    answers = [
        {
            "pair": pair["pair"],
            "question": question,
            "choice": (pair["check"] or ("left" if chooses(pair, question) else "right")),
            "strength": strength(pair, question) if callable(strength) else strength,
            "seconds": round(seconds + number / 1000 + place / 100, 3),
            "plays": 2,
        }
        for place, pair in enumerate(study["pairs"])
        for question in study["questions"]
    ]
    return {
        "kind": "answers",
        "format": 1,
        "study": study["study"],
        "rater": f"{number:016x}",
        "consent": True,
        "started": "2026-01-05T10:00:00Z",
        "finished": "2026-01-05T10:20:00Z",
        "asked": {},
        "answers": answers,
    }


def crowd(study, raters, share, *, spread=0.0, seed=0):
    """Return submissions of raters who prefer `ours` with a share that varies by a spread.

    The share of each rater is beta distributed with an intraclass correlation of `spread`.
    """
    chance = random.Random(seed)  # noqa: S311 no secret

    def rater(number):
        own = share
        if spread:
            size = 1 / spread - 1
            own = chance.betavariate(share * size, (1 - share) * size)
        return submission(
            study,
            number,
            lambda pair, _: (pair["left"] == "ours") == (chance.random() < own),
            strength=lambda *_: chance.randint(1, 5),
        )

    return [rater(number) for number in range(raters)]


def placed(folder, study, submissions, name="answers.jsonl"):
    """Write a study and its answers into a folder, and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.json").write_text(json.dumps(study), "utf-8")
    text = "".join(json.dumps(one) + "\n" for one in submissions)
    (folder / name).write_text(text, "utf-8")
    return folder


def model(study):
    """Return the model of a study."""
    return Study.model_validate_json(json.dumps(study))


def submissions_in(path):
    """Return the submissions in a file of answers; a damaged one raises an error."""
    return [parsed(Submission, text, place) for place, text in texts_of([path])]
