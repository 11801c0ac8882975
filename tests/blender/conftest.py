"""What tests of the command line share."""

from __future__ import annotations

import pytest


@pytest.fixture
def run(capsys):
    """The command in this process: exit code, stdout, stderr."""
    from pt_engine.blender import cli

    def command(*words):
        capsys.readouterr()
        try:
            code = cli.main([str(word) for word in words])
        except SystemExit as leaving:
            code = leaving.code
        return (code, *capsys.readouterr())

    return command
