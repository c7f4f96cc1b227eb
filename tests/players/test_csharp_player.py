"""The player in C# plays like the others, and the component for Unity drives shapes and sound.

Both are compiled and run by Mono. Unity is stood in for: the component never ran in the engine.
"""

import shutil

import pytest
from lanes import full
from played_lines import HERE, PLAYERS, alike, block, ran, shows


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """Compile sources to a program, as Unity would: C# 7.3, and no warning."""
    compiler = shutil.which("mcs") or pytest.skip("no mcs (Debian: mono-mcs)")
    runtime = shutil.which("mono") or pytest.skip("no mono (Debian: mono-runtime)")
    folder = tmp_path_factory.mktemp("mono")

    def build(name, *sources):
        made = folder / f"{name}.exe"
        # Unity assigns the fields that a script never does.
        flags = ("-langversion:7", "-warnaserror", "-nowarn:0649", f"-out:{made}")
        ran(compiler, *flags, *map(str, sources))
        return runtime, str(made)

    return build


@pytest.fixture(scope="module")
def player(program):
    return program("player", PLAYERS / "takes.cs", HERE / "player.cs")


@full
def test_csharp_plays_alike(player, archive, steps, truth):
    alike(ran(*player, str(archive), str(steps[0])), truth)


@full
def test_csharp_refuses_damaged_archives_in_its_own_words(player, wrecks):
    refused, played = map(int, ran(*player, "damaged", str(wrecks)).split())
    assert refused > 50
    assert played > 500


@full
def test_csharp_makes_no_garbage_while_it_plays(player, archive):
    assert int(ran(*player, "frames", str(archive))) == 0


@full
def test_the_component_for_unity_shows_the_weights_and_starts_the_sound(program, archive, tmp_path):
    sources = [PLAYERS / "takes.cs", PLAYERS / "TakesFace.cs", HERE / "unity.cs"]
    sources.append(block(tmp_path / "Talk.cs", "csharp"))
    shows(ran(*program("unity", *sources), str(archive), "en/line-1"), archive, "en/line-1")
