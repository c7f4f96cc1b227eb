"""Examples in public docstrings are run, and every public function has one."""

import doctest
import importlib.util

import pytest
from lanes import swept

import lipsync_lang as ll

FUNCTIONS = [name for name in ll.__all__ if name[0].islower() and callable(getattr(ll, name))]
assert FUNCTIONS, "a sweep over nothing passes"
METHODS = {"Performer": ["perform"], "Animation": ["to_frame"], "Schedule": ["from_intervals"]}
"""Methods with examples, by class."""

NEEDS = {
    "align": ["espeakng_loader", "pocketsphinx"],
    "recognise": ["espeakng_loader", "pocketsphinx"],
    "speak": ["espeakng_loader"],
    "transcribe": ["espeakng_loader"],
    "Animation.to_frame": ["pandas"],
}
"""The packages of extras that an example needs."""


PUBLIC = [*FUNCTIONS, *(f"{kind}.{name}" for kind, names in METHODS.items() for name in names)]


@pytest.mark.parametrize("name", swept(PUBLIC, quick=[n for n in PUBLIC if n not in NEEDS]))
def test_the_example_of_a_docstring_comes_out(name, tmp_path, monkeypatch):
    for package in NEEDS.get(name, ()):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"the example of {name} needs {package}, which is an extra")
    monkeypatch.chdir(tmp_path)
    value = ll
    for step in name.split("."):
        value = getattr(value, step)
    parsed = doctest.DocTestParser().get_doctest(value.__doc__, {"ll": ll}, name, None, None)
    assert parsed.examples, f"{name} shows no example"
    told = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(parsed, out=told.append)
    assert not told, "".join(told)
