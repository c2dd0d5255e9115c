"""Tests of the command line may replace its runs by a stub."""

import pytest
from support.command_line import Stub

import nrchain.run.simulation
import nrchain.view.plots


@pytest.fixture
def stub(monkeypatch):
    stub = Stub()
    monkeypatch.setattr(nrchain.run.simulation, "simulate", stub.simulate)
    monkeypatch.setattr(nrchain.run.simulation, "resume", stub.resume)
    return stub


@pytest.fixture
def blank_pictures(monkeypatch):
    """The picture of a run is an empty file: to draw it takes longer than a short run."""

    def save_chain(trajectory, path):
        path.write_bytes(b"")
        return path

    monkeypatch.setattr(nrchain.view.plots, "save_chain", save_chain)
