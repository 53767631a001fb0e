"""Tell the program's own files from this package and from installed libraries."""

from __future__ import annotations

import sysconfig
from functools import cache
from pathlib import Path
from typing import Final

PACKAGE: Final = Path(__file__).resolve().parents[1]
"""Folder of this package."""

_LIBRARIES: Final = tuple(
    Path(path).resolve() for path in {*map(sysconfig.get_path, ("stdlib", "purelib", "platlib"))}
)


#: names of what is typed at the prompts of Python and asyncio, of Python 3.13 on, and of IPython
_PROMPTS: Final = ("<stdin>", "<console>", "<python-input", "<ipython-input")


@cache
def of_program(file: str) -> bool:
    """Whether a file belongs to the program, and not to this package or an installed library."""
    if file.startswith("<"):
        return file.startswith(_PROMPTS)
    path = Path(file).resolve()
    installed = {"site-packages", "dist-packages"} & set(path.parts)
    return not installed and not any(map(path.is_relative_to, (PACKAGE, *_LIBRARIES)))
