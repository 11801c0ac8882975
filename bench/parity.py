"""docs/node-parity.md and docs/bsdf-parity.md: shader nodes and closures beside Cycles.

`python -m bench.parity` asks everything; `nodes KIND ...` or `closures` only a part, which is printed.
"""

from __future__ import annotations

import argparse
import sys

from .machine import ROOT

sys.path.insert(0, str(ROOT / "tests"))

DOCS = ROOT / "docs"


def main() -> None:
    """Parse the command line, measure, write the pages."""
    parser = argparse.ArgumentParser(prog="python -m bench.parity", description=__doc__)
    parser.add_argument("what", nargs="?", choices=("nodes", "closures", "all"), default="all")
    parser.add_argument("kinds", nargs="*", help="of nodes, without ShaderNode (default: all)")
    arguments = parser.parse_args()
    if arguments.what in ("nodes", "all"):
        from .parity_nodes import page

        text = page(arguments.kinds)
        if arguments.kinds:
            sys.stdout.write(text)
        else:
            (DOCS / "node-parity.md").write_text(text, encoding="utf-8")
    if arguments.what in ("closures", "all"):
        from .parity_closures import page as closures_page

        (DOCS / "bsdf-parity.md").write_text(closures_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
