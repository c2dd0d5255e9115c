"""Tests of the command line may replace its runs by a stub."""

import pytest
from support.command_line import Stub

import nrchain.run.simulation


@pytest.fixture
def stub(monkeypatch):
    stub = Stub()
    monkeypatch.setattr(nrchain.run.simulation, "simulate", stub.simulate)
    monkeypatch.setattr(nrchain.run.simulation, "resume", stub.resume)
    return stub
