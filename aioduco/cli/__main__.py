"""`python -m aioduco.cli`: the command `aioduco` where its script is not on the path."""

from __future__ import annotations

from aioduco.cli import main

if __name__ == "__main__":
    main()
