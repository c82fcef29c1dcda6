"""A command whose options stand in named groups, and whose lists of numbers may be typed with spaces."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any

from typer.core import TyperCommand

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBERS = re.compile(rf",?{_NUMBER}(?:,{_NUMBER})*,?")
_FOR_ONE_ARM = re.compile(r"[A-Z]=")
_OTHERS = "Options"
_MOST_COLUMNS = 24
"""Columns for the names of options; a longer one stands on a line of its own."""


class GroupedCommand(TyperCommand):
    """One command of ``urdf-ik``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, ``--xyz 0.4 0 0.3`` as ``--xyz 0.4,0,0.3``."""
        lists = {name for each in self.get_params(ctx) if "," in (each.metavar or "") for name in each.opts}
        return super().parse_args(ctx, with_commas(args, lists))

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, then the options by their groups, in the order in which these first occur."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for each in self.get_params(ctx):
            record = each.get_help_record(ctx)
            if record is not None:
                argument = each.param_type_name == "argument"
                name = "Arguments" if argument else getattr(each, "rich_help_panel", None) or _OTHERS
                groups.setdefault(name, []).append(record)
        help_page = groups.get(_OTHERS, [])[-1:]  # --help is the last option of every command
        groups[_OTHERS] = groups.get(_OTHERS, [])[:-1]
        groups[next(reversed([name for name in groups if groups[name]]), _OTHERS)] += help_page
        for name, records in groups.items():
            if records:
                with formatter.section(name):
                    formatter.write_dl(records, col_max=_MOST_COLUMNS)


def with_commas(args: Sequence[str], lists: Collection[str]) -> list[str]:
    """Arguments with the numbers that follow an option of ``lists`` in one of them, with commas between.

    Example:
        >>> with_commas(["ur5", "--xyz", "0.4", "-0.1", "0.3", "--rpy=0", "0", "0"], {"--xyz", "--rpy"})
        ['ur5', '--xyz', '0.4,-0.1,0.3', '--rpy=0,0,0']
    """
    out: list[str] = []
    k = 0
    while k < len(args) and args[k] != "--":
        name, sign, value = args[k].partition("=")
        out.append(args[k])
        k += 1
        if name not in lists:
            continue
        if not sign and k < len(args):
            value = args[k]
            out.append(value)
            k += 1
        if _NUMBERS.fullmatch(_FOR_ONE_ARM.sub("", value, count=1)):
            while k < len(args) and _NUMBERS.fullmatch(args[k]):
                out[-1] = f"{out[-1].rstrip(',')},{args[k].strip(',')}"
                k += 1
    return [*out, *args[k:]]
