"""Certificates as data: saved, loaded, checked; what was tampered with does not hold."""

from dataclasses import replace

import pytest
from whole_problems import bracketed

from jounce.shaping import Certificate, Limits, certify, min_time_move
from jounce.shaping.optimal.proof import CostateLink, Proof, TaylorLink
from jounce.shaping.optimal.proof_check import holds

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


@pytest.mark.parametrize("how", list(falsified(certify(PROBLEM.solve(), PROBLEM.limits).proof)))
def test_a_falsified_proof_does_not_hold(certificate, how):
    assert holds(certificate.proof)
    assert not holds(falsified(certificate.proof)[how])


def test_a_certificate_that_claims_more_than_its_proof_does_not_hold(certificate):
    assert not replace(certificate, lower_bound=1.001 * certificate.lower_bound).check()
    assert not replace(certificate, gap=0.5 * certificate.gap).check()


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
