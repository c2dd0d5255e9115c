"""An interruption is reported at once, while jobs under way come to their end."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from nrchain.jobs.crew import Crew, Job
from nrchain.jobs.ledger import Ledger
from nrchain.run.interruption import Interruption

started = threading.Event()


def until_told(interruption):
    """A job that ends once it is told to."""
    started.set()
    end = time.monotonic() + 60.0
    while not interruption.name and time.monotonic() < end:
        time.sleep(0.01)
    return {"told": bool(interruption.name)}


def interrupt(interruption):
    """Interrupt once the job is under way."""
    started.wait(60.0)
    interruption.interrupt("a test")


def test_who_interrupts_is_told_at_once_what_is_waited_for():
    interruption, counts = Interruption(), []
    with ThreadPoolExecutor(1) as executor:
        crew = Crew(Ledger({}), executor, interruption, waits=counts.append)
        threading.Thread(target=interrupt, args=[interruption]).start()
        jobs = [Job(name, until_told, ()) for name in ("first", "second", "third")]
        with pytest.raises(KeyboardInterrupt):
            crew.do(jobs)
        # the second job waits for the one thread, and is cancelled
        assert counts == [1]
