"""Installs the driver's launch files, parameters and view, and its command."""

from pathlib import Path

from setuptools import setup

NAME = "aioduco_driver"
SHARE = f"share/{NAME}"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (SHARE, ["package.xml"]),
        *(
            (f"{SHARE}/{folder}", sorted(str(path) for path in Path(folder).iterdir()))
            for folder in ("config", "launch", "rviz")
        ),
    ],
    entry_points={"console_scripts": [f"driver = {NAME}.driver:main"]},
    zip_safe=True,
)
