"""The Python that scripts run in: one of their own, with the libraries that they need."""

import os
import subprocess
import sys
import venv
from pathlib import Path


def enter(folder, packages):
    """Goes on in the Python of `folder`, which is made if it is not there."""
    home = Path(folder).resolve() / "venv"
    if Path(sys.prefix) == home:
        return
    python = home / "bin" / "python"
    if not python.is_file():
        print(f"making a Python in {home} with {', '.join(packages)}", file=sys.stderr)
        venv.create(home, with_pip=True)
    subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", *packages], check=True)
    os.execv(python, [str(python), *sys.argv])
