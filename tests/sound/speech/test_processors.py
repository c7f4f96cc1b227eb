"""Lines with sound are the same, byte for byte, on every kind of x86 processor."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full

CPU = Path("/proc/cpuinfo")
KERNELS = {"Prescott": "pni", "Haswell": "avx2", "SkylakeX": "avx512f"}
"""Kernels of OpenBLAS, and the instructions that they need."""

SCRIPT = """
import hashlib, sys
import lipsync_lang as ll
performer = ll.resolve("english", "facefx")
text = "The birch canoe slid on the smooth planks. Glue the sheet to the dark blue background."
audio = ll.speak(text, "english").audio
heard = [ll.align(audio, text, "english", aligner=one) for one in ("pocketsphinx", "warp")]
for schedule in [*heard, ll.recognise(audio, "english", recogniser="sound")]:
    told = repr((schedule.labels, schedule.times.tolist(), schedule.likely, schedule.confidence))
    for name in ("a.csv", "a.json", "a.glb"):
        performer.perform(schedule).save(name)
        told += hashlib.sha256(open(name, "rb").read()).hexdigest()
    print(hashlib.sha256(told.encode()).hexdigest())
"""


@full
@pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"} or not CPU.is_file(),
    reason="the kernels are those of x86, named by Linux",
)
def test_a_line_is_the_same_with_every_kernel_of_the_processor(tmp_path):
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("dtaidistance")
    known = {*CPU.read_text("utf-8").split()}
    named = [name for name, needed in KERNELS.items() if needed in known]
    if len(named) < 2:
        pytest.skip("the processor has one kernel alone")
    found = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT], cwd=tmp_path, check=True, capture_output=True,
            env=os.environ | {"OPENBLAS_CORETYPE": name}, text=True,
        ).stdout
        for name in named
    }  # fmt: skip
    assert len(found) == 1
    assert len(found.pop().split()) == 3
