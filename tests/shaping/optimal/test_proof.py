"""Certificates as data: saved, loaded, checked; what was tampered with does not hold."""

import json
from dataclasses import replace

import pytest
from whole_problems import bracketed

from jounce.shaping import Certificate, Limits, certify, min_time_move
from jounce.shaping.optimal.proof import CostateLink, MirroredLink, Proof, TaylorLink
from jounce.shaping.optimal.proof_check import holds

SYMMETRIC = Limits.from_bounds([1.5, 6.0, 60.0, 900.0])
PROBLEM = next(problem for problem in bracketed() if problem.name == "st4-rand8")


@pytest.fixture(scope="module")
def certificate():
    return certify(PROBLEM.solve(), PROBLEM.limits)


def test_a_certificate_comes_back_from_a_file(certificate, tmp_path):
    certificate.save(tmp_path / "proof.json")
    again = Certificate.load(tmp_path / "proof.json")
    assert again == certificate
    assert again.check()
    assert Proof.from_text(certificate.proof.text()) == certificate.proof


def falsified(proof):
    last = proof.links[-1]
    n = len(proof.start)
    first = next(i for i, link in enumerate(proof.links) if isinstance(link, CostateLink))
    turned = replace(last, ends=tuple(-x for x in last.ends))
    longer = replace(last, high=1.001 * last.high)
    return {
        "a higher bound": replace(proof, lower_bound=1.0001 * proof.lower_bound),
        "a link less": replace(proof, links=(*proof.links[:first], *proof.links[first + 1 :])),
        "no links": replace(proof, links=()),
        "multipliers turned": replace(proof, links=(*proof.links[:-1], turned)),
        "an interval stretched": replace(
            proof, links=(*proof.links[:-1], longer), lower_bound=longer.high
        ),
        "an end nearer": replace(proof, end=(0.9 * proof.end[0], *proof.end[1:])),
        "a wider bound": replace(proof, upper=(*proof.upper[:-1], 1.1 * proof.upper[-1])),
        "no bound": replace(proof, upper=(*[float("inf")] * n, proof.upper[-1])),
        "cells left out": replace(
            proof, links=(*proof.links[:-1], replace(last, cells=last.cells[:-1]))
        ),
        "a Taylor link that is none": replace(
            proof, links=(TaylorLink(0.0, proof.lower_bound, 0, n, 1),)
        ),
    }


def test_a_falsified_proof_does_not_hold(certificate):
    assert holds(certificate.proof)
    for how, proof in falsified(certificate.proof).items():
        assert not holds(proof), how


def test_a_certificate_that_claims_more_than_its_proof_does_not_hold(certificate):
    assert not replace(certificate, lower_bound=1.001 * certificate.lower_bound).check()
    assert not replace(certificate, gap=0.5 * certificate.gap).check()


FALSE = {
    "a duration below the bound": lambda made: {"duration": 0.5 * made.lower_bound},
    "a longer duration": lambda made: {"duration": 1.1 * made.duration},
    "a larger gap": lambda made: {"gap": made.gap + 0.1},
    "a bound that costs nothing": lambda made: {
        "slopes": tuple((0.9 * low, 0.9 * high) for low, high in made.slopes)
    },
    "no slopes": lambda _: {"slopes": ()},
    "other sensitivities": lambda made: {"sensitivities": made.sensitivities[::-1]},
    "no sensitivities": lambda _: {"sensitivities": ()},
}


@pytest.mark.parametrize("how", FALSE)
def test_what_a_certificate_says_besides_has_to_fit(certificate, how):
    assert certificate.check()
    assert not replace(certificate, **FALSE[how](certificate)).check()


@pytest.mark.parametrize(
    ("distance", "bounds"),
    [(-1.0, [(-1, 2), 4.0, (-30, 60), 400]), (2000.0, [20.0, (-4, 1), 10.0, 100.0]), (1.0, [2, 9])],
)
def test_slopes_are_checked_for_every_kind_of_proof(distance, bounds):
    limits = Limits.from_bounds(bounds)
    made = certify(min_time_move(distance, limits), limits)
    assert made.check()
    other = tuple((0.99 * low, 0.99 * high) for low, high in made.slopes)
    assert not replace(made, slopes=other).check()


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (["proof", "links", 0, "low"], None),
        (["proof", "links", 0, "low"], "0.0"),
        (["proof", "links", 0, "kind"], "Link"),
        (["proof", "links", -1, "ends", 0], float("inf")),
        (["proof", "links", -1, "cells", 0], float("nan")),
        (["proof", "links", 0, "derivative"], 0.5),
        (["proof", "end", 0], None),
        (["proof", "upper", 2], "9"),
        (["proof", "upper"], [None]),
        (["duration"], "1"),
        (["rtol"], -1.0),
    ],
    ids=str,
)
def test_numbers_that_are_none_are_refused_where_the_file_is_read(
    certificate, path, value, tmp_path
):
    certificate.save(tmp_path / "proof.json")
    data = json.loads((tmp_path / "proof.json").read_text())
    part = data
    for key in path[:-1]:
        part = part[key]
    assert path[-1] in part or isinstance(part, list)
    part[path[-1]] = value
    (tmp_path / "proof.json").write_text(json.dumps(data))
    with pytest.raises(ValueError, match=r"holds no certificate: expected what certificate.save"):
        Certificate.load(tmp_path / "proof.json")


def test_from_rest_to_rest_one_link_is_enough():
    limits = Limits(acceleration=(-4.0, 1.0), jerk=20.0, snap=300.0)
    proof = certify(min_time_move(1.0, limits), limits)
    assert len(proof.proof.links) == 1
    assert proof.check()


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"format": 3}', '{"duration": 1}'])
def test_files_that_hold_no_certificate_are_refused(text, tmp_path):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(ValueError, match=r"holds no certificate: expected what certificate.save"):
        Certificate.load(tmp_path / "x.json")
    with pytest.raises(ValueError, match=r"is no proof: expected what certificate.save wrote"):
        Proof.from_text(text)


ALIKE = [[2.0], [2.0, 9.0], [1.5, 6.0, 60.0], [1.5, 6.0, 60.0, 900.0], [None] * 4 + [1e4],
    [0.05, None, None, 384.0], [(-1, 2), 4.0, (-30, 60), 400],
    [2, 9, 90, 900, 9e3, 1e5]]  # fmt: skip


@pytest.mark.parametrize("bounds", ALIKE, ids=str)
@pytest.mark.parametrize(
    ("distance", "method"), [(1.0, "optimal"), (-1.0, "optimal"), (1.0, "closed-form")]
)
def test_every_move_of_alike_even_bounds_has_a_proof_of_one_link(
    bounds, distance, method, tmp_path
):
    limits = Limits.from_bounds(bounds)
    certificate = certify(min_time_move(distance, limits, start=0.25, method=method), limits)
    assert certificate.check()
    assert certificate.lower_bound == certificate.proof.lower_bound > 0.0
    assert len(certificate.proof.links) == 1
    certificate.save(tmp_path / "proof.json")
    assert Certificate.load(tmp_path / "proof.json") == certificate


HALVES = {
    "a longer duration": lambda link: {"high": 1.001 * link.high},
    "multipliers turned": lambda link: {"ends": tuple(-x for x in link.ends)},
    "velocity not free in the middle": lambda link: {"ends": (link.ends[0], 0.1, *link.ends[2:])},
    "half a cruise": lambda link: {"cruise": 0.5 * link.cruise},
    "a cruise of less than no time": lambda _: {"cruise": -1.0},
    "an atom more": lambda link: {"atoms": ((1, (1.0,) * len(link.cells)), *link.atoms[1:])},
    "bounds on position": lambda link: {"atoms": ((0, link.cells), *link.atoms)},
}


@pytest.mark.parametrize("how", HALVES)
def test_a_falsified_half_does_not_hold(how):
    limits = Limits.from_bounds([0.05, None, None, 384.0])
    proof = certify(min_time_move(1.0, limits), limits).proof
    [link] = proof.links
    assert isinstance(link, MirroredLink)
    assert link.cruise > 0.0
    false = replace(link, **HALVES[how](link))
    assert holds(proof)
    assert not holds(replace(proof, links=(false,), lower_bound=false.high))


@pytest.mark.parametrize("change", ["start", "end"])
def test_halves_are_mirrored_between_states_of_rest_only(change):
    proof = certify(min_time_move(1.0, SYMMETRIC), SYMMETRIC).proof
    state = getattr(proof, change)
    assert holds(proof)
    assert not holds(replace(proof, **{change: (state[0], 0.01, *state[2:])}))
