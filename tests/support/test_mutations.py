"""The list of mutations is up to date; `scripts/mutate` tries them."""

import pytest
from support.mutations import MUTATIONS, ROOT


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name)
def test_a_mutation_has_its_place_and_its_tests(mutation):
    """Each stands in one place of its file as it is now, changes it, and names tests that exist."""
    source = (ROOT / "pt_engine" / mutation.file).read_text(encoding="utf-8")
    assert source.count(mutation.right) == 1
    assert mutation.right != mutation.wrong
    assert all((ROOT / test).exists() for test in mutation.tests.split())


def test_there_are_enough_of_them():
    assert len({mutation.name for mutation in MUTATIONS}) == len(MUTATIONS) >= 20
