"""The check of `doctor`: the models of Whisper."""

from lipsync_lang.commands import doctor_checks
from lipsync_lang.commands.doctor_checks import MORE_CHECKS
from lipsync_lang.plugins.whisper import whisper_check, whisper_recogniser


def test_a_whisper_without_a_model_is_told(monkeypatch):
    monkeypatch.setattr(whisper_check, "find_spec", lambda _: True)
    monkeypatch.setattr(whisper_recogniser, "SHIPPED", {})
    (found,) = MORE_CHECKS["whisper"]()
    assert (found.part, found.state) == ("model of whisper", "missing")
    assert "whisper:FOLDER" in found.told


def test_a_downloaded_whisper_is_listed_and_is_no_acoustic_model(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(whisper_check, "find_spec", lambda _: True)
    monkeypatch.setattr(whisper_recogniser, "SHIPPED", {})
    folder = tmp_path / "models" / "whisper-small"
    folder.mkdir(parents=True)
    for name in whisper_recogniser.MODEL_FILES:
        (folder / name).write_text("{}")
    (found,) = MORE_CHECKS["whisper"]()
    assert (found.state, found.told) == ("ok", f"--recogniser whisper:{folder}")
    assert not [one for one in doctor_checks.acoustic_models() if "whisper" in one.part]
    (folder / "tokenizer.json").unlink()
    (found,) = MORE_CHECKS["whisper"]()
    assert (found.state, "tokenizer.json missing" in found.told) == ("broken", True)
