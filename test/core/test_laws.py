"""Every law that ``cloth_validate`` prints holds; and a law that is broken is seen."""

from __future__ import annotations

import json

import pytest

from cloth_core.validation import INTEGRATORS, LAWS, Check, Law, Measurement, cli

CASES = [pytest.param(law, i, id=f"{law.name}-{i}") for law in LAWS for i in law.integrators if i not in law.exempt]


@pytest.mark.parametrize(("law", "integrator"), CASES)
def test_law(law, integrator):
    check = law.check(integrator)
    assert check.error <= check.bound, check


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_laws_have_a_sentence_and_every_exemption_a_reason(law):
    assert law.formula.endswith(".") and len(law.formula) < 110
    assert all(integrator in INTEGRATORS and len(reason) > 20 for integrator, reason in law.exempt.items())
    assert set(law.exempt) < set(law.integrators)


@pytest.mark.parametrize("law", [law for law in LAWS if "swing" in law.name], ids=lambda law: law.name)
def test_the_swings_of_meyer2000_are_rightly_exempt(law):
    """It does not swing at all, or far too slowly: an exemption that is no longer needed should go."""
    found = law.measure("meyer2000")
    assert found.measured > 1.5 * found.expected


def test_errors_are_relative_and_absolute_where_zero_is_expected():
    assert Check("a", "-", 2.0, 2.1, 0.1).error == pytest.approx(0.05)
    assert Check("a", "-", 0.0, -0.3, 0.1).error == pytest.approx(0.3)
    assert not Check("a", "-", 0.0, -0.3, 0.1).passed
    assert not Check("a", "-", 1.0, float("nan"), 0.1).passed
    assert Check("a", "-", 0.0, 0.0, 0.0, exempt="because").passed


def test_the_table_and_the_file_tell_the_same(tmp_path, capsys):
    path = tmp_path / "laws.json"
    assert (
        cli.main(["--only", "free-fall", "--only", "total mass", "--json", str(path), "--integrator", "meyer2000"]) == 0
    )
    printed = capsys.readouterr().out
    content = json.loads(path.read_text())
    assert content["passed"] is True
    assert [(c["law"], c["integrator"]) for c in content["checks"]] == [("free fall", "meyer2000"), ("total mass", "-")]
    assert "free fall" in printed and "pass" in printed and "2 checks: 2 pass, 0 fail" in printed


def test_a_law_that_fails_is_shown_and_sets_the_exit_status(monkeypatch, capsys):
    def measure(_integrator):
        """Two is one."""
        return Measurement(1.0, 2.0, 0.1, "m")

    broken = Law("arithmetic", measure, exempt={"meyer2000": "it never learned to count that far"})
    monkeypatch.setattr(cli, "LAWS", (broken,))
    assert cli.main([]) == 1
    printed = capsys.readouterr().out
    assert "FAIL" in printed and "exempt: it never learned" in printed
    assert "1 checks: 0 pass, 1 fail, 1 exempt" in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "gravitas"], "no such law; laws are free fall"),
        (["--integrator", "rk4"], "invalid choice"),
        (["--json", "/no/such/folder/laws.json"], "does not exist"),
    ],
)
def test_a_wrong_call_says_what_would_be_right(arguments, message, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(arguments)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


def test_help_names_every_law(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["--help"])
    assert stop.value.code == 0
    printed = capsys.readouterr().out
    assert all(law.name in printed and law.formula in printed for law in LAWS)
