# SPDX-License-Identifier: MPL-2.0
"""Icons of the commands."""
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "icons"


def path(name):
    """The file of an icon."""
    return str(FOLDER / f"batten_{name}.svg")
