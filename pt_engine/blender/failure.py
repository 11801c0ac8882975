"""Why a command ends without its result."""

from __future__ import annotations


class Failure(Exception):
    """It can't be done; the message is one clear line."""

    exit_code = 1


class UsageError(Failure):
    """The command makes no sense as it was given."""

    exit_code = 2
