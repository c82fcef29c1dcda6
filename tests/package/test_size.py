"""The project's size within its budgets, as tools/size.py measures it."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
if not (ROOT / ".git").exists():
    pytest.skip("only what git tracks is counted", allow_module_level=True)
SIZE = runpy.run_path(str(ROOT / "tools" / "size.py"))
FIGURES = SIZE["sizes"]()


@pytest.mark.parametrize("row", SIZE["BUDGETS"])
def test_no_budget_is_exceeded(row: str) -> None:
    """Delete before you add."""
    figure, budget = FIGURES[row], SIZE["BUDGETS"][row]
    assert figure <= budget, f"{row}: {figure:,} of {budget:,}"
