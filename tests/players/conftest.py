"""An archive of 500 lines, steps on it, and the weights of the player in Python after each."""

import shutil
from zlib import crc32

import numpy as np
import pytest
from played_lines import HERE, PLAYERS, ran, speech, take

from lipsync_lang.build.takes import TAKES_HEADER, encoded, write_takes
from lipsync_lang.players.takes import Archive, Player

LINES = 500


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
    """Return steps of a play on every line, in a file and as a list."""
    random = np.random.default_rng(35)
    told = []
    for name in said:
        told += [f"play {name} {random.choice([0, 0.1, 0.3]):g}", "advance 0.016667"]
        told += [f"advance {random.uniform(0, 0.5):.4f}" for _ in range(2)]
        told += [f"seek {random.uniform(-0.5, 3):.4f}", f"seek {random.uniform(-0.5, 1):.4f}"]
        told += [f"blend {random.choice(['max', 'add', 'replace'])}"]
        other = name.replace("en/", "de/") if name.startswith("en") else name.replace("de/", "en/")
        told += [f"switch {other} 0.2", "advance 0.05"]
        told += ["skip 0.1", "advance 0.04"] if random.random() < 0.5 else []
    told += ["play en/none 0.1"]
    path = archive.with_name("steps.txt")
    path.write_text("\n".join(told) + "\n", "utf-8", newline="\n")
    return path, told


@pytest.fixture(scope="session")
def truth(archive, steps):
    rows = []
    with Archive(archive) as opened:
        player = Player(opened)
        count = len(opened.poses)
        own, region, out = [0.3] * count, [n % 2 for n in range(count)], [0.0] * count
        for step in steps[1]:
            verb, what, *value = step.split()
            if verb in ("play", "switch"):
                getattr(player, verb)(what, float(value[0]))
            elif verb == "blend":
                player.blend(own, what, region, out)
            else:
                getattr(player, verb)(float(what))
            rows.append([*(out if verb == "blend" else player.weights), player.sound_time])
    return np.array(rows)


@pytest.fixture(scope="session")
def wrecks(tmp_path_factory):
    """Return a folder of 300 damaged archives; most have right checksums, to get behind them."""
    random = np.random.default_rng(36)
    folder = tmp_path_factory.mktemp("wrecks")
    whole = encoded({f"en/{n}": take(speech(random, 60)) for n in range(6)})
    first = TAKES_HEADER.unpack_from(whole)[7]
    for number in range(300):
        content = bytearray(whole)
        for _ in range(random.integers(1, 5)):
            parts = (8, 64), (64, first), (first, first + 300), (first, len(content))
            content[random.integers(*parts[random.integers(4)])] = random.integers(256)
        if random.random() < 0.1:
            content = content[: random.integers(1, len(content))]
        if random.random() < 0.8 and len(content) > first:
            content[40:48] = len(content).to_bytes(8, "little")
            head = crc32(content[52:first], crc32(content[:48]))
            content[48:52] = head.to_bytes(4, "little")
        (folder / f"{number}.takes").write_bytes(content)
    return folder


@pytest.fixture
def compiled(tmp_path):
    """Compile a program of this folder."""
    compiler = shutil.which("gcc") or shutil.which("clang") or pytest.skip("no C compiler")

    def build(name, *flags):
        program = tmp_path / name
        given = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{PLAYERS}", *flags]
        ran(compiler, *given, str(HERE / f"{name}.c"), "-o", str(program))
        return str(program)

    return build
