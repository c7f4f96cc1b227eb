"""An archive of 500 lines, damaged ones, steps on them, and programs that take the steps."""

import os
import shutil
import struct
from zlib import crc32

import numpy as np
import pytest
from played_lines import HERE, PLAYERS, SANITIZED, ran, speech, take

from lipsync_lang.production.builds.takes import TAKES_HEADER, encoded, write_takes

LINES = 500
NUMBERS = (np.nan, np.inf, -np.inf, 1e30, -1e10, -1e8, 1e-30, -0.5, 2e6, -3e5)
NUMBERS_AT = (2, 3, 4, 9, 10, 13, 14, 17, 18)
"""Places of rate, start, delay, least values and ranges in the first take, in steps of 4 bytes."""


@pytest.fixture(scope="session")
def said():
    random = np.random.default_rng(34)
    return {f"{'de' if n % 2 else 'en'}/line-{n // 2}": speech(random) for n in range(LINES)}


@pytest.fixture(scope="session")
def archive(said, tmp_path_factory):
    path = tmp_path_factory.mktemp("takes") / "a.takes"
    write_takes(path, {name: take(one) for name, one in said.items()})
    return path


@pytest.fixture(scope="session")
def steps(said, archive):
    """Return steps of a play on every line."""
    random = np.random.default_rng(35)
    told = [f"open {archive}"]
    for name in said:
        told += [f"play {name} {random.choice([0, 0.1, 0.3]):g}", "advance 0.016667"]
        told += [f"advance {random.uniform(0, 0.5):.4f}" for _ in range(2)]
        told += [f"seek {random.uniform(-0.5, 3):.4f}", f"seek {random.uniform(-0.5, 1):.4f}"]
        told += [f"blend {random.choice(['max', 'add', 'replace'])}"]
        other = name.replace("en/", "de/") if name.startswith("en") else name.replace("de/", "en/")
        told += [f"switch {other} 0.2", "advance 0.05"]
        told += ["skip 0.1", "advance 0.04"] if random.random() < 0.5 else []
    return [*told, "play en/none 0.1"]


@pytest.fixture(scope="session")
def wreck_steps(tmp_path_factory):
    """Return steps on 300 damaged archives; most have right checksums, to get behind them."""
    random = np.random.default_rng(36)
    folder = tmp_path_factory.mktemp("wrecks")
    whole = encoded({f"en/{n}": take(speech(random, 60)) for n in range(6)})
    first = TAKES_HEADER.unpack_from(whole)[7]
    told = []
    for number in range(300):
        content = bytearray(whole)
        for _ in range(random.integers(1, 5)):
            parts = (8, 64), (64, first), (first, first + 300), (first, len(content))
            content[random.integers(*parts[random.integers(4)])] = random.integers(256)
        if random.random() < 0.5:
            at = first + 4 * int(random.choice(NUMBERS_AT))
            content[at : at + 4] = struct.pack("<f", random.choice(NUMBERS))
        if random.random() < 0.1:
            content = content[: random.integers(1, len(content))]
        if random.random() < 0.8 and len(content) > first:
            content[40:48] = len(content).to_bytes(8, "little")
            head = crc32(content[52:first], crc32(content[:48]))
            content[48:52] = head.to_bytes(4, "little")
        path = folder / f"{number}.takes"
        path.write_bytes(content)
        told.append(f"open {path}")
        for line in range(6):
            told += [f"play en/{line} 0.1", *["advance 0.1"] * 8, "seek 0.3"]
            told += [f"switch en/{5 - line} 0.1", "blend replace", "skip 0.1", "advance 0.02"]
    return told


@pytest.fixture(scope="session")
def mono(tmp_path_factory):
    """Compile sources of C# to a program, as Unity would: C# 7.3, and no warning."""
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


@pytest.fixture
def compiled(tmp_path):
    """Compile a program of this folder."""
    compiler = shutil.which("gcc") or shutil.which("clang") or pytest.skip("no C compiler")

    def build(name):
        program = tmp_path / name
        given = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{PLAYERS}", *SANITIZED]
        ran(compiler, *given, str(HERE / f"{name}.c"), "-o", str(program))
        return str(program)

    return build


@pytest.fixture(params=["c", "csharp", "javascript", "godot"])
def play(request, tmp_path):
    """Run steps with a player, and return its output."""
    path = tmp_path / "steps.txt"
    options = {}
    if request.param == "c":
        command = [request.getfixturevalue("compiled")("player"), str(path)]
    elif request.param == "csharp":
        sources = [PLAYERS / "takes.cs", HERE / "player.cs"]
        command = [*request.getfixturevalue("mono")("player", *sources), str(path)]
    elif request.param == "javascript":
        node = shutil.which("node") or pytest.skip("no node")
        command = [node, str(HERE / "player.mjs"), str(PLAYERS / "takes.mjs"), str(path)]
    else:
        program = shutil.which("godot3-server") or pytest.skip("no godot3-server")
        for part in (PLAYERS / "takes.gd", HERE / "player.gd"):
            shutil.copy(part, tmp_path)
        (tmp_path / "project.godot").write_text("config_version=4\n")
        command = [program, "--path", str(tmp_path), "--script", "player.gd"]
        options["env"] = {**os.environ, "HOME": str(tmp_path), "LC_ALL": "en_GB.UTF-8"}

    def run(steps):
        path.write_text("\n".join(steps) + "\n", "utf-8", newline="\n")
        told = ran(*command, **options)
        if request.param == "godot":
            told = "\n".join(line for line in told.splitlines() if line.startswith("SAID "))
        return told

    return run
