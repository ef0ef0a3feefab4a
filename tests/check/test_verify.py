"""Certificates: yes for what is generated, and the right no for each impostor."""
import json
from types import SimpleNamespace

import numpy as np
import pytest
from support.pages import DOCS, blocks, python, sh
from support import impostors as wrong, texts
from support.runtime_faults import FAULTS
from support.systems import CLASSICAL, SPECS, VESELOV, load, tiers

import smidgen
from smidgen.errors import RunError, UsageError, ValidationError
from smidgen.run.settings import settle
from smidgen.check.verify import integrals
from smidgen.check.verify.certificate import certify
from smidgen.check.verify.row import CLAIMS, NO, NOT_APPLICABLE, YES, at_most, at_least
from smidgen.check.verify.subject import emitted

SIZES = {"heisenberg_chain": {"n": 10}, "honeycomb": {"nx": 2, "ny": 2}, "j1j2_chain": {"n": 10},
         "landau_lifshitz": {"n": 12}, "cubic_lattice": {"nx": 2, "ny": 2, "nz": 2},
         "test_particles": {"n": 5}, "vortex_tracers": {"m": 4}}
SHORT = 1000            # steps of round-off where something else is looked at
quick, long = pytest.mark.quick, pytest.mark.long


@pytest.fixture(autouse=True)
def outside_the_long_tier(request):
    if not request.node.get_closest_marker("long"):
        request.getfixturevalue("few_states")


def said(certificate, verdict):
    """The names of the rows with this verdict."""
    return {row.name for row in certificate.rows if row.verdict == verdict}


def judged(system, impostor, tier=SHORT, values=None, run=None, **more):
    """The certificate of an impostor in the place of the generated code for a system's spec."""
    certificate = certify(load(system.name), run, tier=tier, subject=impostor, parameters=values, **more)
    print(certificate.text())
    return certificate


def generated(spec, **given):
    return emitted(spec, settle(spec, None, **given))


# -- yes ---------------------------------------------------------------------------------------

@pytest.mark.parametrize("name", tiers(SPECS, ("free_rigid_body", "nambu_a34"), ("heisenberg_chain", "vortex_tracers")))
def test_every_shipped_spec_is_certified(name):
    certificate = smidgen.verify(load(name), tier="quick", parameters=SIZES.get(name, {}))
    print(certificate.text())
    assert said(certificate, NO) == set()
    assert {"order", "symplectic", "tangent map", "tangent symplectic", "reversible", "casimirs", "field",
            "energy formula", "step", "residual"} <= said(certificate, YES)


@pytest.mark.long
@pytest.mark.parametrize("name", SPECS)
def test_every_shipped_spec_is_certified_at_length(name):
    certificate = smidgen.verify(load(name), parameters=SIZES.get(name, {}))
    print(certificate.text())
    assert said(certificate, NO) == set()


@pytest.mark.long
@pytest.mark.parametrize("text", [texts.FIELD, texts.MIXED, texts.PULSE, texts.OPEN_CHAIN])
def test_specs_beyond_the_shipped_ones_are_certified(text):
    """Strengths of both signs, radii, reversed bracket, time, open ends."""
    certificate = smidgen.verify(texts.read(text), tier="quick")
    print(certificate.text())
    assert said(certificate, NO) == set()


@pytest.mark.parametrize("name, seeds", [("free_rigid_body", 2), *(
    pytest.param(name, 5, marks=long) for name in ("free_rigid_body", "point_vortices", "two_bodies", "test_particles"))])
def test_no_false_alarm_at_other_states(name, seeds):
    spec, values = load(name), SIZES.get(name, {})
    for seed in range(seeds):
        assert said(certify(spec, tier=SHORT, parameters=values, seed_of_checks=seed), NO) == set()


@pytest.mark.parametrize("name, h", [("forced_rigid_body", -np.pi / 30), *(pytest.param("point_vortices", h, marks=long) for h in (0.01, 0.4, -0.1))])
def test_any_step_is_certified(name, h):
    assert said(smidgen.verify(load(name), tier=SHORT, h=h), NO) == set()


def test_what_a_system_has_is_found():
    chain = smidgen.verify(load("heisenberg_chain"), tier=SHORT, parameters={"n": 6})
    assert chain.row("equivariant").note == "all rotations" and chain.row("momentum").verdict == YES
    assert chain.row("energy").verdict == NOT_APPLICABLE
    body = smidgen.verify(load("free_rigid_body"), tier=SHORT)
    assert said(body, YES) >= {"energy", "quadratic integrals"} and "no rotation" in body.row("equivariant").note


@long
def test_what_fields_and_tracers_have_is_found():
    field = smidgen.verify(texts.read(texts.FIELD), tier=SHORT)
    assert field.row("equivariant").note.replace("-", "") == "about (0.36, 0.48, 0.8)" and field.row("energy").verdict == YES
    assert "time" in smidgen.verify(load("forced_rigid_body"), tier=SHORT).row("energy").note
    tracers = smidgen.verify(load("vortex_tracers"), tier=SHORT, parameters={"m": 2})
    assert said(tracers, YES) >= {"symplectic", "tracers' area", "momentum"}


# -- no: methods -------------------------------------------------------------------------------

@pytest.mark.long
def test_a_list_in_place_of_one_number_is_certified():
    spec = texts.read('[model]\nname = "m"\n[parameters]\nK = { default = 1.0, size = 3 }\n[space]\nw = { sphere = 3, kappa = "K[i]" }\n'
                      '[effects.e]\nover = "pair(i, j)"\nenergy = "dot(w[i], w[j])"\n')
    found = certify(spec, h=0.1, steps=10, parameters={"K": [1.0, 3.0, 0.5]}, tier=SHORT)
    assert found.row("momentum").verdict == YES and found.passed, found.text()


@pytest.mark.parametrize("name, run", [("irreversible_rigid_body", "classical"), pytest.param("point_vortices", None, marks=long)])
def test_the_classical_midpoint_is_not_symplectic(name, run):
    """Its own generated code, judged as what it is: no for what it is not, nothing else."""
    certificate = smidgen.verify(load(name), run, tier=SHORT, method=CLASSICAL)
    assert {"symplectic", "tangent symplectic"} == said(certificate, NO)
    assert certificate.row("symplectic").measured > 1e-8
    assert said(certificate, YES) >= {"order", "reversible", "casimirs", "step", "residual", "field"}
    assert certificate.row("energy").verdict == NOT_APPLICABLE       # nobody claims it
    with pytest.raises(ValidationError, match="symplectic"):
        certificate.check()


def test_the_classical_midpoint_that_coincides_is_symplectic():
    """On the Heisenberg algebra it is the spherical midpoint: no prejudice."""
    assert smidgen.verify(load("nambu_a31"), tier=SHORT, method=CLASSICAL).row("symplectic").verdict == YES


@quick
def test_moser_veselov_is_certified_on_the_free_body():
    assert smidgen.verify(load("free_rigid_body"), tier=SHORT, method=VESELOV).passed


WITNESS = {"step", "residual"}
METHODS = [
    # system, impostor, rows that must say no, rows that must say yes all the same
    (wrong.IrreversibleBody, wrong.ClassicalMidpoint, {"symplectic"}, {"order", "reversible", "casimirs"}),
    (wrong.IrreversibleBody, wrong.GeodesicMidpoint, {"symplectic"}, {"order", "reversible", "casimirs"}),
    (wrong.Chain, wrong.ClassicalMidpoint, {"symplectic"}, {"order", "reversible", "momentum", "casimirs"}),
    (wrong.Chain, wrong.GeodesicMidpoint, {"symplectic", "momentum"}, {"order", "reversible", "casimirs"}),
    (wrong.Chain, wrong.FrozenSublattices, {"symplectic", "momentum"}, {"order", "reversible", "casimirs"}),
    (wrong.Chain, wrong.AxisSplitting, {"momentum", "equivariant"}, {"order", "reversible", "casimirs", "symplectic"}),
    (wrong.FreeBody, wrong.ProjectedMidpoint, {"energy", "quadratic integrals", "symplectic", "reversible"}, {"order", "casimirs"}),
    (wrong.IrreversibleBody, wrong.ProjectedMidpoint, {"symplectic", "reversible"}, {"order", "casimirs"}),
    (wrong.IrreversibleBody, wrong.RenormalisedEuler, {"order", "symplectic", "reversible"}, {"casimirs"}),
    (wrong.Chain, wrong.RenormalisedEuler, {"order", "symplectic", "reversible", "momentum"}, {"casimirs", "equivariant"}),
    (wrong.IrreversibleBody, wrong.ExplicitMidpoint, {"casimirs", "symplectic", "reversible"}, {"order"}),
]


# Left to the long tier: on a chain hundreds of iterations a step; on a body their compiled fellows are refused below and in test_comparators.py.
SLOW = (wrong.ClassicalMidpoint, wrong.GeodesicMidpoint)


def methods(chosen):
    return pytest.mark.parametrize("system, impostor, no, yes", chosen, ids=lambda x: getattr(x, "__name__", None))


@methods([one for one in METHODS if one[1] not in (*SLOW, wrong.FrozenSublattices)])
def test_another_method_in_its_place_is_refused(system, impostor, no, yes):
    """A hundred steps, two states: an impostor shows at once what it is."""
    refused(system, impostor, no, yes, steps=100)


@long
@methods(METHODS)
def test_another_method_in_its_place_is_refused_at_length(system, impostor, no, yes):
    refused(system, impostor, no, yes)


def refused(system, impostor, no, yes, **more):
    values = {"n": 8} if system is wrong.Chain else None
    certificate = judged(system, impostor(system()), values=values, **more)
    assert no | WITNESS <= said(certificate, NO)
    assert yes | {"field", "energy formula"} <= said(certificate, YES)
    return certificate


def test_frozen_sublattices_keep_the_energy():
    """Exactly, which makes them hard to refuse: only the tangent map and the momentum tell."""
    chain = wrong.FrozenSublattices(wrong.Chain())
    w = np.array(wrong.unit(np.random.default_rng(1).standard_normal((8, 3))))
    after = chain.run(w[None], 0.0, 0.1, [1000])[0, 0]
    assert abs(chain.energy(after, 0) - chain.energy(w, 0)) < 1e-12
    assert refused(*next(one for one in METHODS if one[1] is wrong.FrozenSublattices), steps=100).row("symplectic").measured > 1e-5


def test_an_iteration_left_early_drifts():
    certificate = judged(wrong.IrreversibleBody(), wrong.EarlyStop(wrong.IrreversibleBody()), steps=100)
    assert {"round-off", "residual"} <= said(certificate, NO)
    assert certificate.row("round-off").measured > 0.8


# -- no: generated code with a fault -----------------------------------------------------------

@pytest.mark.parametrize("spec", [load("forced_rigid_body"), *(pytest.param(texts.read(text), marks=long) for text in (texts.PULSE, texts.MIXED))],
                         ids=lambda s: s.name)
def test_a_frozen_time_shows_as_order_one(spec):
    certificate = certify(spec, tier=SHORT, subject=wrong.compiled(spec, wrong.frozen_time))
    print(certificate.text())
    assert {"order", "reversible", "step", "residual"} <= said(certificate, NO)
    assert certificate.row("order").measured == pytest.approx(1, abs=0.1)
    assert said(certificate, YES) >= {"symplectic", "casimirs", "field"}


@pytest.mark.long
def test_a_frozen_time_shows_where_it_is_weak():
    """A hundred thousandth of the energy depends on time, and nothing of it at the start."""
    text = texts.PULSE.replace("2*exp(-(t - 1)^2)*w.x + sin(3*t)*w.y^2", "1e-5*cos(3*t)*w.x")
    spec = texts.read(text)
    assert smidgen.verify(spec, tier=SHORT).passed
    certificate = certify(spec, tier=SHORT, subject=wrong.compiled(spec, wrong.frozen_time))
    print(certificate.text())
    assert certificate.row("order").verdict == NO and certificate.row("order").measured < 1.5


@pytest.mark.long
def test_a_reversed_bracket_is_refused():
    spec = load("point_vortices")
    certificate = certify(spec, tier=SHORT, subject=wrong.compiled(spec, wrong.turned_round))
    assert {"order", "step", "residual", "run", "whole space", "sums", "refusals"} == said(certificate, NO)
    assert said(certificate, YES) >= {"symplectic", "reversible", "momentum", "field", "tangent map"}


@pytest.mark.parametrize("name, effect", [pytest.param("product", "coupling", marks=long), ("forced_rigid_body", "loading"),
                                          pytest.param("j1j2_chain", "far", marks=long)])
def test_a_wrong_sign_with_its_hessian_is_refused(name, effect):
    """The step is a perfect symplectic map of another system."""
    spec, values = load(name), SIZES.get(name, {})
    certificate = certify(spec, tier=SHORT, parameters=values, subject=generated(wrong.wrong_sign(spec, effect), parameters=values))
    print(certificate.text())
    assert {"order", "field", "energy formula", "step", "residual"} <= said(certificate, NO)
    assert said(certificate, YES) >= {"symplectic", "tangent map", "tangent symplectic", "reversible", "casimirs"}


@pytest.mark.long
def test_a_small_turn_is_refused():
    """A millionth of h, symplectic and on the spheres: the flow and the interpreter tell."""
    spec = load("irreversible_rigid_body")
    certificate = certify(spec, tier=SHORT, subject=wrong.Lopsided(generated(spec)))
    assert {"order", "step", "residual"} <= said(certificate, NO)
    assert said(certificate, YES) >= {"symplectic", "casimirs", "field"}


def test_a_tangent_of_another_step_is_refused():
    spec = load("irreversible_rigid_body")
    subject = generated(spec)
    assert "tangent map" in said(certify(spec, tier=SHORT, subject=wrong.WrongTangent(subject), steps=100), NO)
    rough = certify(spec, tier=SHORT, subject=wrong.RoughTangent(subject), steps=100)
    assert said(rough, NO) == {"tangent symplectic", "sums"}        # started anew at each step, it has no carry


@pytest.mark.long
def test_tracers_of_the_classical_midpoint_are_not_carried_by_area():
    certificate = smidgen.verify(load("vortex_tracers"), tier=SHORT, parameters={"m": 3}, method=CLASSICAL)
    assert {"symplectic", "tracers' area"} <= said(certificate, NO)


@quick
def test_a_step_that_fails_is_a_no():
    class Refuses(wrong.Impostor):
        def motion(self, w, t, h):
            raise RunError("step 1: no convergence")
    certificate = judged(wrong.FreeBody(), Refuses(wrong.FreeBody()))
    assert said(certificate, NO) == {"steps"} and not certificate.passed


@quick
def test_a_step_that_is_not_finite_is_a_no():
    class Lost(wrong.Impostor):
        def motion(self, w, t, h):
            return w * np.nan
    assert not judged(wrong.FreeBody(), Lost(wrong.FreeBody())).passed
    for row in (at_most("order", np.nan, 1), at_least("order", np.nan, 1), at_most("order", np.inf, 1)):
        assert row.verdict == NO


def test_every_row_has_said_no_here():
    """The impostors above meet each property that a certificate states."""
    met = {x for _, _, no, _ in METHODS for x in no} | WITNESS
    met |= {"run", "whole space", "branch", "sums", "round-off size", "outputs"}     # test_verify_faults.py
    met |= {fault.row for fault in FAULTS.values()}     # test_verify_layouts.py
    met |= {"steps", "round-off", "field", "energy formula", "tangent map", "tangent symplectic", "tracers' area"}
    assert met == set(CLAIMS)


# -- JSON, the command, the header -------------------------------------------------------------

@quick
def test_the_json_says_all():
    certificate = smidgen.verify(load("free_rigid_body"), tier=SHORT, parameters={"I2": 1.5})
    data = json.loads(certificate.to_json())
    assert data["format"] == "smidgen certificate" and data["version"] == 2 and data["passed"] is True
    assert data["set"] == {"I2": 1.5} and data["spec_digest"] == load("free_rigid_body").digest
    assert data["flags"] and data["compiler"] and len(data["generator_digest"]) == 64
    rows = {row["name"]: row for row in data["rows"]}
    assert rows["order"]["measured"] == certificate.row("order").measured       # all digits
    assert rows["momentum"]["measured"] is None and rows["momentum"]["verdict"] == NOT_APPLICABLE


@quick
def test_wrong_words_are_errors_of_usage():
    for given in ({"tier": "thorough"}, {"tier": 10}, {"tier": True}, {"method": "euler"}, {"effects": ["none"]}):
        with pytest.raises(UsageError):
            smidgen.verify(load("free_rigid_body"), **given)


# -- the header --------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(file, data) of a certificate of the free body."""
    file = tmp_path_factory.mktemp("certificate") / "top.json"
    certificate = smidgen.verify(load("free_rigid_body"), tier=SHORT)
    file.write_text(certificate.to_json())
    return file, json.loads(certificate.to_json())


def test_the_header_carries_the_certificate(made, command, tmp_path):
    file, data = made
    assert command("gen", "free_rigid_body", "--out", "plain").returncode == 0
    done = command("gen", "free_rigid_body", "--out", "sure", "--certificate", file)
    assert done.returncode == 0, done.stderr
    plain, sure = ((tmp_path / where / "free_rigid_body.h").read_text() for where in ("plain", "sure"))
    block, rest = sure.split("*/", 1)
    assert rest == plain.split("*/", 1)[1] and "Certificate: yes" in block
    for row in data["rows"]:
        assert (f" *   {row['name']:20} yes" in block) == (row["verdict"] == YES)
    names = " ".join(row["name"] for row in data["rows"])
    assert all(row["note"] not in block for row in data["rows"] if row["note"] and row["note"] not in names)


def test_the_certificate_of_other_code_is_refused(made, command):
    file, _ = made
    for words in (["heisenberg_chain"], ["free_rigid_body", "--method", CLASSICAL],
                  ["free_rigid_body", "--set", "I2=1.5"], ["free_rigid_body", "--features", "extended"]):
        done = command("gen", *words, "--certificate", file)
        assert done.returncode == 2 and "the certificate belongs to another spec" in done.stderr


HOSTILE = {
    "another generator": lambda d: d.update(generator_digest="0" * 64),
    "a comment's end as a name": lambda d: d["rows"][0].update(name="*/ int main(void) {} /*"),
    "a comment's end as a verdict": lambda d: d["rows"][0].update(verdict="yes */"),
    "a relation of its own": lambda d: d["rows"][1].update(relation="*/"),
    "text as a number": lambda d: d["rows"][1].update(measured="1e-16 */"),
    "NaN": lambda d: d["rows"][1].update(measured=float("nan")),
    "infinity": lambda d: d["rows"][1].update(measured=float("inf")),
    "a truth as a number": lambda d: d["rows"][1].update(measured=True),
    "a verdict that the numbers deny": lambda d: d["rows"][1].update(measured=50.0),
    "a yes without numbers": lambda d: d["rows"][2].update(measured=None, bound=None, relation=""),
    "a whole that the rows deny": lambda d: d.update(passed=False),
    "the same row twice": lambda d: d["rows"].append(d["rows"][0]),
    "no rows": lambda d: d.update(rows=[]),
    "rows that are none": lambda d: d.update(rows={"order": 2}),
    "a row that is none": lambda d: d.update(rows=[["order"]]),
    "another format": lambda d: d.update(format="certificate"),
    "another version": lambda d: d.update(version=1),
    "h as text": lambda d: d.update(h="0.1 */"),
    "huge": lambda d: d.update(pad="x" * (1 << 20)),
}


@pytest.mark.parametrize("fault", HOSTILE)
def test_a_hostile_certificate_is_refused(made, tmp_path, fault):
    from smidgen.compile.select import select
    from smidgen.check.verify.embed import read_certificate
    file, data = made
    scene = select(load("free_rigid_body"))
    assert read_certificate(file, scene, "spherical-midpoint", "auto")
    data = json.loads(json.dumps(data))
    HOSTILE[fault](data)
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(data))
    with pytest.raises(UsageError, match="bad.json"):
        read_certificate(bad, scene, "spherical-midpoint", "auto")


@pytest.mark.parametrize("text", ["", "[]", "{", "\x00\xff", "[" * 100000, "9" * 5000], ids=range(6))
def test_what_is_no_certificate_is_refused(tmp_path, text):
    from smidgen.compile.select import select
    from smidgen.check.verify.embed import read_certificate
    (tmp_path / "bad.json").write_text(text, encoding="latin-1")
    for name in ("bad.json", "missing.json", "."):
        with pytest.raises(UsageError):
            read_certificate(tmp_path / name, select(load("free_rigid_body")), "spherical-midpoint", "auto")


def test_the_command(command, tmp_path):
    done = command("verify", "free_rigid_body", "--quick", "--json", "top.json")
    assert done.returncode == 0 and "symplectic" in done.stdout and "\x1b" not in done.stdout
    assert json.loads((tmp_path / "top.json").read_text())["passed"] is True
    done = command("verify", "irreversible_rigid_body", "classical", "--long", "1e3", "--json", "-")
    assert done.returncode == 5 and "not certified: symplectic" in done.stderr
    assert json.loads(done.stdout)["passed"] is False
    assert command("verify", "free_rigid_body", "--quick", "--json", "no/such/folder").returncode == 8
    for words in (["--long", "10"], ["--quick", "--long", "1e4"], ["--h", "0"], ["nosuchrun"]):
        assert command("verify", "free_rigid_body", *words).returncode == 2


@long
def test_the_page_runs(tmp_path):
    sh("smidgen new spins\n" + "".join(blocks("verify.md", "sh")), tmp_path)
    assert "symplectic" in python(blocks("verify.md", "python")[0], tmp_path)


@quick
def test_the_page_names_every_row():
    page = (DOCS / "verify.md").read_text()
    assert all(f"| {name} |" in page or name in ("field", "energy formula") for name in CLAIMS)


@pytest.mark.quick
def test_sums_over_many_sites_are_no_error_of_the_method():
    """4096 spins nearly along one axis, and the same in another order: sums in double alone would differ by more than is allowed."""
    dice = np.random.default_rng(1)
    w = dice.normal(size=(4096, 3)) * 0.1 + [0, 0, 1]
    w /= np.linalg.norm(w, axis=1)[:, None]
    path = np.array([w, dice.permutation(w)])
    one = integrals.Integral(lambda w: np.einsum("si,i->", w, np.array([0.0, 0.0, 1.0])), scale=64.0)
    assert np.abs(one.changes(*path)).max() > 16 * np.finfo(float).eps and integrals.along(SimpleNamespace(path=path), one) < 1
