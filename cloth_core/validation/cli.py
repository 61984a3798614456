"""``cloth_validate``: hold the solver to the laws of physics and print one table."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from cloth_core.validation import INTEGRATORS, LAWS, Check, Law

DESCRIPTION = """\
Play small scenes whose outcome is known in closed form, and print what was expected, what was
measured and how far the two may differ. Errors are relative to the expected value, or absolute
where zero is expected. Laws that an integrator cannot obey are listed with the reason.

The whole takes well under a minute; the exit status is 1 if a law fails and 2 for a wrong call."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    chosen = _chosen(options.only, parser)
    if options.json and not options.json.resolve().parent.is_dir():
        parser.error(f"--json {options.json}: the folder {options.json.resolve().parent} does not exist")

    started = time.monotonic()
    pairs = list(_pairs(chosen, options.integrator))
    checks = []
    for number, (law, integrator) in enumerate(pairs, 1):
        _progress(f"[{number}/{len(pairs)}] {law.name}, {integrator}")
        checks.append(law.check(integrator))
    _progress("")
    print(table(checks))
    failed = [check for check in checks if not check.passed]
    exempt = sum(bool(check.exempt) for check in checks)
    print(
        f"\n{len(checks) - exempt} checks: {len(checks) - exempt - len(failed)} pass, {len(failed)} fail"
        f"{f', {exempt} exempt' if exempt else ''}; {time.monotonic() - started:.0f} s"
    )
    if options.json:
        try:
            options.json.write_text(as_json(checks))
        except OSError as error:
            parser.error(f"--json {options.json}: {error.strerror}")
    return 1 if failed else 0


def as_json(checks: Sequence[Check]) -> str:
    """``{"passed": ..., "checks": [...]}``, one mapping per :class:`Check`."""
    content = {"passed": all(check.passed for check in checks), "checks": [check.as_mapping() for check in checks]}
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def table(checks: Sequence[Check]) -> str:
    """The checks as aligned text."""
    rows = [("law", "integrator", "expected", "measured", "error", "bound", "")]
    for check in checks:
        if check.exempt:
            rows.append((check.law, check.integrator, "", "", "", "", f"exempt: {check.exempt}"))
        else:
            expected, measured = (f"{value:.6g} {check.unit}".strip() for value in (check.expected, check.measured))
            verdict = "pass" if check.passed else "FAIL"
            numbers = (expected, measured, f"{check.error:.1e}", f"{check.bound:.0e}")
            rows.append((check.law, check.integrator, *numbers, verdict))
    widths = [*(max(len(row[column]) for row in rows) for column in range(6)), 0]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def _parser() -> argparse.ArgumentParser:
    laws = "\n".join(f"  {law.name:22}{law.formula}" for law in LAWS)
    parser = argparse.ArgumentParser(
        prog="cloth_validate",
        description=DESCRIPTION,
        epilog=f"laws:\n{laws}\n\nexample:\n  cloth_validate --only 'strip swing 1' --only catenary --json laws.json",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", metavar="NAME", action="append", default=[], help="only this law; may be given again")
    parser.add_argument("--integrator", choices=INTEGRATORS, help="only this integrator; both by default")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the table to this file, too")
    return parser


def _chosen(names: Sequence[str], parser: argparse.ArgumentParser) -> list[Law]:
    known = {law.name: law for law in LAWS}
    wanted = [name.replace("-", " ").replace("_", " ") for name in names]
    for name in wanted:
        if name not in known:
            parser.error(f"--only {name!r}: no such law; laws are {', '.join(known)}")
    return [known[name] for name in dict.fromkeys(wanted)] or list(LAWS)


def _pairs(laws: Sequence[Law], integrator: str | None) -> Iterator[tuple[Law, str]]:
    """Each law with each integrator that is asked for; laws of geometry come once, whatever the integrator."""
    for law in laws:
        for candidate in law.integrators:
            if integrator in (None, candidate) or candidate not in INTEGRATORS:
                yield law, candidate


def _progress(text: str) -> None:
    """One line that is overwritten, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
