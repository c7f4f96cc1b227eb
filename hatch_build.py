"""Build the compiled kernel into wheels and editable installs, where there is a C compiler.

    python hatch_build.py    builds it in place, beside `kernel.c`

Its absence costs only speed, so that a build without a compiler, or with one that fails, says so
and goes on. `LIPSYNC_LANG_KERNEL=off` leaves it out.
"""

import os
import sys
import sysconfig
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).resolve().parent
SOURCE = Path("lipsync_lang/pipeline/kernel.c")
MODULE = "lipsync_lang.pipeline._kernel"

EXACT = ["-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
"""Options of GCC and Clang: products are rounded before they are added, on every machine alike."""


def build_in(folder: Path, *, anew: bool) -> Path:
    """Compile the kernel into a folder, in its package; return the library.

    It is built against Python's stable interface, and serves every Python from 3.11 on. A library
    that is newer than its sources is kept, unless it is to be built anew.
    """
    from setuptools import Distribution, Extension
    from setuptools.command.build_ext import build_ext

    class Build(build_ext):
        def build_extension(self, ext: Any) -> None:
            if self.compiler.compiler_type != "msvc":
                ext.extra_compile_args = EXACT
            super().build_extension(ext)

    sources = {"sources": [str(SOURCE)], "depends": [Path(__file__).name]}
    extension = Extension(MODULE, **sources, py_limited_api=True)
    command = Build(Distribution({"ext_modules": [extension]}))
    with TemporaryDirectory() as objects:
        command.build_temp, command.build_lib, command.force = objects, str(folder), anew
        command.ensure_finalized()
        command.run()
    return folder / command.get_ext_filename(MODULE)


def compiled_or_reason(folder: Path, *, anew: bool = True) -> Path | str:
    """Compile the kernel; return the library, or the reason why there is none."""
    if os.environ.get("LIPSYNC_LANG_KERNEL", "").strip().lower() == "off":
        return "LIPSYNC_LANG_KERNEL is off"
    here = Path.cwd()
    try:
        os.chdir(ROOT)
        return build_in(folder, anew=anew)
    # compilers fail in many ways, and distutils leaves by SystemExit too
    except (Exception, SystemExit) as error:  # noqa: BLE001
        return f"{type(error).__name__}: {error}"
    finally:
        os.chdir(here)


class KernelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the kernel to a wheel, which is then of this platform; or builds it in place."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before files are collected."""
        editable = version == "editable"
        self.built = None if editable else TemporaryDirectory()
        # other extras are installed later, and compiling takes longer than they do
        folder = ROOT if self.built is None else Path(self.built.name)
        found = compiled_or_reason(folder, anew=not editable)
        if isinstance(found, str):
            self.app.display_warning(f"no compiled kernel, which costs only speed: {found}")
            return
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-{platform}"
        if not editable:
            inside = (SOURCE.parent / found.name).as_posix()
            build_data["force_include"][str(found)] = inside

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was compiled for the wheel."""
        del version, build_data, artifact_path
        if self.built is not None:
            self.built.cleanup()


if __name__ == "__main__":
    built = compiled_or_reason(ROOT)
    sys.exit(f"no compiled kernel: {built}" if isinstance(built, str) else None)
