"""Reading a spec of very many sites or entries takes bounded memory, and what is too much is said."""
import subprocess
import sys

import pytest
import smidgen
from smidgen.language import limits
from smidgen.read import checks

MEMORY = 400 << 20      # bytes of address space for the reader; the numbers below would take more
HEAD = '[model]\nname = "large"\n[space]\nw = {{ sphere = {count}{more} }}\n[effects.e]\nover = "site(i) of w"\nenergy = "w[i].z"\n'
FORMULAS = '[starts.s]\ntheta = "0.1*i"\nphi = "sin(i)^2 + i"\n'
READ = "import sys, resource\nresource.setrlimit(resource.RLIMIT_AS, ({0}, {0}))\nimport smidgen\n" \
       "try:\n smidgen.load_text(sys.stdin.read())\n print('a spec')\nexcept smidgen.SpecError as error:\n print(error)"


def read(text):
    """What a process of bounded memory says of the text."""
    done = subprocess.run([sys.executable, "-c", READ.format(MEMORY)], input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_strengths_and_radii_of_a_hundred_million_sites():
    assert read(HEAD.format(count=limits.SITES, more=', kappa = "1 + i", radius = "2 + sin(i)"')) == "a spec\n"


@pytest.mark.parametrize("count", [10, pytest.param(limits.STARTS, marks=pytest.mark.long)])
def test_starts_of_very_many_sites(count):
    """Many of them: reading looks at as many sites as a bounded number of operations pays for."""
    starts = "".join(FORMULAS.replace("starts.s", f"starts.s{k}") for k in range(count))
    assert read(HEAD.format(count=limits.SITES, more="") + starts) == "a spec\n"


def test_a_fault_beyond_what_reading_looks_at_is_found_when_it_is_used(monkeypatch):
    monkeypatch.setattr(checks, "WORK", 0)
    monkeypatch.setattr(checks, "LEAST", 5)
    spec = smidgen.load_text(HEAD.format(count=9, more=', kappa = "7 - i"') + "[starts.s]\nrandom = 1\n")
    with pytest.raises(smidgen.RunError, match="cannot start.*kappa of site 7 is 0"):
        smidgen.run(spec, h=0.1, steps=1)
    spec = smidgen.load_text(HEAD.format(count=9, more="") + '[starts.s]\nx = "if(i == 6, 2, 1)"\ny = "0"\nz = "0"\n')
    with pytest.raises(smidgen.UsageError, match="site 6 of 'w' starts at"):
        smidgen.run(spec, h=0.1, steps=1)


def test_arrays_are_limited_together():
    arrays = "".join(f"g{k} = {{ default = 1.0, size = {limits.ARRAY} }}\n" for k in range(100))
    said = read(HEAD.format(count=1, more="") + "[parameters]\n" + arrays)
    assert "error[E105]" in said and "with the arrays before it 20000000" in said


@pytest.mark.parametrize("more, said", [
    (', kappa = "i - 5"', "the strength of `w[5]` is 0"), (', radius = "7.5 - i"', "the radius of `w[8]` is -0.5"),
    (', kappa = "1/(i - 9)"', "the strength of `w[9]` is inf")])
def test_a_fault_in_any_block_is_found(monkeypatch, more, said):
    for block in (1, 2, 3, 100):
        monkeypatch.setattr(checks, "BLOCK", block)
        with pytest.raises(smidgen.SpecError) as caught:
            smidgen.load_text(HEAD.format(count=20, more=more))
        assert said in str(caught.value) and len(caught.value.diagnostics) == 1


@pytest.mark.parametrize("start, said", [
    ('x = "1 + (if(i == 11, 1, 0))"\ny = "0"\nz = "0"', "`w[11]` has length 2"),
    ('x = "1/(i - 13)"\ny = "0"\nz = "0"\nnormalise = true', "`w[13]` is not finite"),
    ('x = "i - 7"\ny = "0"\nz = "0"\nnormalise = true', "`w[7]` starts at zero")])
def test_a_fault_of_a_start_in_any_block_is_found(monkeypatch, start, said):
    for block in (1, 2, 3, 100):
        monkeypatch.setattr(checks, "BLOCK", block)
        with pytest.raises(smidgen.SpecError) as caught:
            smidgen.load_text(HEAD.format(count=20, more="") + f"[starts.s]\n{start}\n")
        assert said in str(caught.value) and len(caught.value.diagnostics) == 1


def test_a_size_given_on_the_command_line(tmp_path, capsys):
    """n = 1e7 makes an array of 1e14 entries."""
    from smidgen.cli import main
    (tmp_path / "a.toml").write_text(HEAD.format(count=1, more="") + '[parameters]\nn = 3\ng = { default = 1.0, size = "n*n" }\n')
    assert main(["run", str(tmp_path / "a.toml"), "--set", "n=10000000"]) == 2
    assert "100000000000000 entries; at most 10000000" in capsys.readouterr().err


def test_a_lack_of_memory_is_said(capsys):
    from types import SimpleNamespace

    from smidgen.cli import guarded

    def too_much(args):
        raise MemoryError
    assert guarded(SimpleNamespace(command=too_much)) == 2
    assert "not enough memory" in capsys.readouterr().err
