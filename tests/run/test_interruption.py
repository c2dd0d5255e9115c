"""The first signal waits for the end of a step, a second does not; the file is always closed."""

import signal

import pytest

from nrchain.run import interruption


@pytest.mark.parametrize(
    ("first", "second"), [(signal.SIGINT, signal.SIGTERM), (signal.SIGTERM, signal.SIGTERM)]
)
def test_a_second_signal_ends_a_step_and_a_third_is_put_off(monkeypatch, first, second):
    monkeypatch.setattr(interruption, "PATIENCE", 0.0)
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    reached = []

    def run():
        with interruption.deferred() as noted:
            try:
                with noted.second_at_once():
                    signal.raise_signal(first)
                    reached.append(noted.name)
                    signal.raise_signal(second)
                    reached.append("the end of the step")
            finally:
                signal.raise_signal(signal.SIGTERM)
                signal.raise_signal(signal.SIGINT)
                reached.append("closed")

    with pytest.raises(KeyboardInterrupt):
        run()
    assert reached == [first.name, "closed"]
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
