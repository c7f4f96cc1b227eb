"""The check of `doctor`: the program of the Montreal Forced Aligner, and its models."""

from lipsync_lang.commands.doctor_checks import MORE_CHECKS
from lipsync_lang.plugins.mfa import mfa_check


def test_a_missing_program_is_named(monkeypatch):
    monkeypatch.setattr(mfa_check.shutil, "which", lambda _: None)
    (found,) = MORE_CHECKS["mfa"]()
    assert (found.part, found.state) == ("mfa", "missing")
    assert "montreal-forced-aligner" in found.told


def test_models_are_counted_and_missing_ones_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(mfa_check.shutil, "which", lambda name: f"/bin/{name}")
    monkeypatch.setenv("MFA_ROOT_DIR", str(tmp_path))
    program, found = MORE_CHECKS["mfa"]()
    assert program[:3] == ("mfa", "ok", "/bin/mfa")
    assert (found.part, found.state) == ("models of mfa", "missing")
    assert "mfa model download acoustic" in found.told
    folder = tmp_path / "pretrained_models/acoustic"
    folder.mkdir(parents=True)
    for number in range(7):
        (folder / f"german{number}.zip").touch()
    _, found = MORE_CHECKS["mfa"]()
    assert (found.state, found.told[-10:]) == ("ok", "and 2 more")
