"""The command ``mimesh``."""

from __future__ import annotations

import signal
import sys

from . import _mimesh, _stages


def main() -> None:
    """Runs the command line of mimesh with the arguments of the process.

    It has an option more than the command that Cargo installs: ``--python FILE`` runs a file that defines stages.
    """
    sys.stdout.flush()
    # Python would note an interrupt for later, and here is no later.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _stages.print_failures()
    sys.exit(_mimesh.main(["mimesh", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
