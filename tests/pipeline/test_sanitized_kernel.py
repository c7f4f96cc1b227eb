"""The compiled kernel under AddressSanitizer and UndefinedBehaviorSanitizer (`make sanitize`)."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from lanes import full
from places import ROOT, TESTS
from sanitized_kernel import LIBRARY

FUZZ_SECONDS = 20

SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")

OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1:max_allocation_size_mb=1024",
    "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1",
    "PYTHONMALLOC": "malloc",  # blocks of Python's own would hide what is read beside them
}


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """Variables of a process whose kernel has sanitizers."""
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("no gcc: the kernel is not compiled with sanitizers")
    runtime = subprocess.run(
        [compiler, "-print-file-name=libasan.so"], check=True, capture_output=True, text=True
    ).stdout.strip()
    if not Path(runtime).is_absolute():
        pytest.skip("gcc has no libasan: the kernel is not compiled with sanitizers")
    made = tmp_path_factory.mktemp("kernel") / "_kernel.so"
    source = ROOT / "lipsync_lang/pipeline/kernel.c"
    include = sysconfig.get_path("include")
    subprocess.run(
        [compiler, "-shared", "-fPIC", "-g", "-O1", *SANITIZERS, f"-I{include}", source, "-o", made,
         "-lm"],
        check=True,
    )  # fmt: skip
    own = {LIBRARY: str(made), "LD_PRELOAD": runtime, "PYTHONPATH": f"{TESTS}:{TESTS / 'pipeline'}"}
    return {**os.environ, **OPTIONS, **own}


def ran(environment, *arguments):
    """Run Python with the sanitized kernel, and return what it prints."""
    done = subprocess.run(
        [sys.executable, *arguments], check=False, cwd=ROOT, env=environment, timeout=300,
        capture_output=True, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
    return done.stdout


@full
def test_the_tests_of_the_kernel_hold_under_sanitizers(environment):
    tests = (
        "tests/pipeline/test_kernel.py",
        "tests/render/test_compiled_samples.py",
        "-m",
        "not full",
    )
    quiet = ("-q", "-p", "no:cacheprovider", "-p", "no:randomly")
    ran(environment, "-m", "pytest", "-p", "sanitized_kernel", *tests, *quiet)


@full
def test_damaged_arguments_are_refused_or_performed_within_bounds(environment):
    seed = os.environ["LIPSYNC_LANG_FUZZ_SEED"]
    script = str(TESTS / "pipeline/sanitized_kernel.py")
    told = ran(environment, script, str(FUZZ_SECONDS), seed)
    assert int(told.split()[0]) > 20
    for name in ("bank", "plan", "utter", "weigh", "energies", "fill", "shade", "average"):
        assert f"{name} refused" in told
