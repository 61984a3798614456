"""``cloth_validate``: hold the solver to the laws of physics, or abuse it and see whether it holds."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from cloth_core.validation import INTEGRATORS, LAWS, Check, Law, torture

DESCRIPTION = """\
Play small scenes whose outcome is known in closed form, and print what was expected, what was
measured and how far the two may differ. Errors are relative to the expected value, or absolute
where zero is expected. Laws that an integrator cannot obey are listed with the reason.

The whole takes well under a minute; the exit status is 1 if a law fails and 2 for a wrong call.

With --torture, abuse random cloths instead, and check in every step that positions and velocities
are finite, that no thread is stretched beyond its limit + 0.05 (default integrator only), and that
the cloth comes to rest once it is left alone. A seed always gives the same episodes; each failure
is printed with the command that plays it again. The exit status is 1 if an episode fails."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    _check(options, parser)
    report, passed = _torture(options) if options.torture else _hold_to_laws(options, parser)
    if options.json:
        try:
            options.json.write_text(json.dumps(report, indent=2, allow_nan=False) + "\n")
        except OSError as error:
            parser.error(f"--json {options.json}: {error.strerror}")
    return 0 if passed else 1


def _hold_to_laws(options: argparse.Namespace, parser: argparse.ArgumentParser) -> tuple[dict[str, object], bool]:
    """Try every law that is asked for; returns what goes into the file, and whether all of them hold."""
    started = time.monotonic()
    pairs = list(_pairs(_chosen(options.only, parser), options.integrator))
    checks = []
    for number, (law, integrator) in enumerate(pairs, 1):
        _progress(f"[{number}/{len(pairs)}] {law.name}, {integrator}")
        checks.append(law.check(integrator))
    _progress("")
    print(table(checks))
    failed = sum(not check.passed for check in checks)
    exempt = sum(bool(check.exempt) for check in checks)
    print(
        f"\n{len(checks) - exempt} checks: {len(checks) - exempt - failed} pass, {failed} fail"
        f"{f', {exempt} exempt' if exempt else ''}; {time.monotonic() - started:.0f} s"
    )
    return {"passed": not failed, "checks": [check.as_mapping() for check in checks]}, not failed


def _torture(options: argparse.Namespace) -> tuple[dict[str, object], bool]:
    """Play episodes for as long as is asked; returns what goes into the file, and whether all of them pass."""
    series = torture.Series(
        options.seed or 0, options.integrator, tuple(options.abuse), options.largest or torture.LARGEST
    )
    outcomes = series.run(minutes=options.torture, only=options.episode)
    failed = sum(not outcome.passed for outcome in outcomes)
    simulated = sum(outcome.duration for outcome in outcomes) / 60.0
    print(torture.table(outcomes))
    print(
        f"\nseed {series.seed}, {len(outcomes)} episodes ({simulated:.1f} simulated minutes): "
        f"{len(outcomes) - failed} pass, {failed} fail"
    )
    episodes = [torture.as_mapping(outcome, series.command(outcome)) for outcome in outcomes]
    return {"passed": not failed, "seed": series.seed, "episodes": episodes}, not failed


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
    abuses = "\n".join(f"  {name:22}{(abuse.__doc__ or '').strip()}" for name, abuse in torture.ABUSES.items())
    parser = argparse.ArgumentParser(
        prog="cloth_validate",
        description=DESCRIPTION,
        epilog=f"laws:\n{laws}\n\nabuses:\n{abuses}\n\nexamples:\n"
        "  cloth_validate --only 'strip swing 1' --only catenary --json laws.json\n"
        "  cloth_validate --torture 10 --seed 7\n"
        "  cloth_validate --torture 1 --seed 7 --episode 42",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", metavar="NAME", action="append", default=[], help="only this law; may be given again")
    parser.add_argument("--integrator", choices=INTEGRATORS, help="only this integrator; both by default")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the results to this file, too")
    torturing = parser.add_argument_group("torture")
    torturing.add_argument(
        "--torture", metavar="MINUTES", type=float, help="abuse cloths for so long (wall-clock time)"
    )
    torturing.add_argument("--seed", metavar="S", type=int, help="which series of episodes; 0 by default")
    torturing.add_argument("--episode", metavar="N", type=int, help="play only this one of the series, from 1")
    torturing.add_argument(
        "--abuse",
        metavar="NAME",
        action="append",
        default=[],
        choices=list(torture.ABUSES),
        help="abuse every cloth in this way only; may be given again",
    )
    torturing.add_argument("--largest", metavar="N", type=int, help="most vertices a side of a cloth, 4 .. 50")
    return parser


def _check(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    """Refuse calls that make no sense."""
    if options.json and not options.json.resolve().parent.is_dir():
        parser.error(f"--json {options.json}: the folder {options.json.resolve().parent} does not exist")
    if options.torture is None:
        for name in ("seed", "episode", "abuse", "largest"):
            if getattr(options, name) not in (None, []):
                parser.error(f"--{name} goes with --torture MINUTES")
        return
    if not (math.isfinite(options.torture) and options.torture > 0.0):
        parser.error(f"--torture {options.torture:g}: more than 0 minutes, please")
    if options.only:
        parser.error("--only names laws, which --torture does not play; did you mean --abuse?")
    for name, least, most in (("seed", 0, math.inf), ("episode", 1, math.inf), ("largest", 4, torture.LARGEST)):
        value = getattr(options, name)
        if value is not None and not least <= value <= most:
            parser.error(
                f"--{name} {value}: a whole number of at least {least}{f', at most {most}' * (most < math.inf)}"
            )


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
