"""Pictures and animations of a simulated arm, as files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.models.whole_files import whole_file

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    Picture = NDArray[np.uint8]


#: suffixes of files that can be written
KINDS = (".gif", ".png")
_SHORTEST = 0.02  # time for which programs can show a picture of an animation [s]


def save(path: Path, pictures: Iterable[Picture], durations: list[float]) -> None:
    """Write an animation, or the last picture if the file's name ends in .png.

    Args:
        path: file to write; its suffix selects the format.
        pictures: at least one. Shape (height, width, 3) each.
        durations: how long each is shown [s].
    """
    from PIL import Image  # noqa: PLC0415 - needs an extra

    images = [Image.fromarray(picture) for picture in pictures]
    if path.suffix == ".png":
        with whole_file(path) as file:
            images[-1].save(file, "png", optimize=True)
        return
    # One palette for all: colours do not flicker, and files are smaller.
    palette = images[len(images) // 2].quantize(128)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    options: dict[str, Any] = {
        "duration": [round(1000 * max(time, _SHORTEST)) for time in durations[: len(frames)]],
        "loop": 0,
        "save_all": True,
        "append_images": frames[1:],
        "optimize": True,
    }
    with whole_file(path) as file:
        frames[0].save(file, "gif", **options)
