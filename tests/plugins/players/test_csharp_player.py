"""The player in C# makes no garbage, and the component for Unity drives shapes and sound.

Both are compiled and run by Mono. Unity is stood in for: the component never ran in the engine.
"""

from lanes import full
from played_lines import HERE, PLAYERS, block, ran, shows


@full
def test_csharp_makes_no_garbage_while_it_plays(mono, archive):
    player = mono("frames", PLAYERS / "takes.cs", HERE / "player.cs")
    assert int(ran(*player, "frames", str(archive))) == 0


@full
def test_the_component_for_unity_shows_the_weights_and_starts_the_sound(mono, archive, tmp_path):
    sources = [PLAYERS / "takes.cs", PLAYERS / "TakesFace.cs", HERE / "unity.cs"]
    sources.append(block(tmp_path / "Talk.cs", "csharp"))
    shows(ran(*mono("unity", *sources), str(archive), "en/line-1"), archive, "en/line-1")
