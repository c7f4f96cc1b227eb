"""Plug-ins open only files with a fuzz target, or with a reason to have none."""

from test_fuzz import opening

NO_TARGET = {
    "plugins/capture/accept_fit.py": "packs, which are a target; opens a pair by its name",
    "plugins/capture/capture_reading.py": "plain text; timings are targets",
    "plugins/capture/fit_command.py": "writes",
    "plugins/festival/festival_engine.py": "what a program of the user's has written",
    "plugins/g2p/niqqud.py": "a model of our own",
    "plugins/heads/face_model.py": "a licence in a mesh, whose lines have tests of their own",
    "plugins/heads/obj_files.py": "numbers by lines; damaged ones have tests of their own",
    "plugins/htk/htk_files.py": "an acoustic model, which the user names",
    "plugins/htk/htk_front_end.py": "settings beside it",
    "plugins/mfa/mfa_aligner.py": "what a program of the user's has written",
    "plugins/mfa/mfa_command.py": "what a program of the user's has written",
    "plugins/programs/vrma.py": "bones of a list of our own",
    "plugins/study/answer_server.py": "a page of our own, and answers, which are a target",
    "plugins/study/making_command.py": "a plain text",
    "plugins/study/methods.py": "banks, which are a target",
    "plugins/study/study_clips.py": "clips of our own, and models, which are a target",
    "plugins/study/study_maker.py": "clips of our own",
    "plugins/study/study_page.py": "scripts of our own",
    "plugins/mouths/bank_move.py": "banks, which are a target",
    "plugins/whisper/whisper_recogniser.py": "a model, which the user names",
}
"""Modules that open files without a target, with the reason."""

HAVE_TARGETS = {
    "plugins/capture/capture_files.py",
    "plugins/capture/capture_reading.py",
    "plugins/capture/fit_file.py",
    "plugins/players/takes.py",
    "plugins/scripts/gettext.py",
    "plugins/smartbody/bank_files.py",
    "plugins/study/study_file.py",
}
"""Modules that open files within a target."""


def test_every_plug_in_that_opens_files_has_a_target_or_a_reason():
    assert opening("plugins/") == NO_TARGET.keys() | HAVE_TARGETS
