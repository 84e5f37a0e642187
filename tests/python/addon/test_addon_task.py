"""Work on a thread: progress, stop, failure, without a window."""

import threading

import pytest

from isimp.task import Status, Stopped, Task, Watch, shares


class Job:
    """Like the engine's: progress and stage for the caller, cancel for the job."""

    def __init__(self, progress=0.0, stage=""):
        self.progress, self.stage, self.cancelled = progress, stage, False

    def cancel(self):
        self.cancelled = True


def test_each_part_has_its_share_of_the_progress():
    assert shares([0.0, 1.0, 3.0]) == [0.0, 0.25, 1.0]


def test_progress_is_that_of_the_job_within_its_part():
    watch = Watch()
    assert (watch.progress, watch.stage) == (0.0, "")
    with watch.part("first", 0.0, 0.2):
        assert watch.stage == "first"
    assert watch.progress == pytest.approx(0.2)
    with watch.part("second", 0.2, 1.0, Job(0.5, "flooding")):
        assert watch.progress == pytest.approx(0.6)
        assert watch.stage == "flooding"
    assert watch.progress == pytest.approx(1.0)


def test_parts_within_a_share_stay_inside_it():
    watch = Watch()
    with watch.share(0.0, 0.6), watch.part("steps", 0.5, 1.0, Job(0.5)):
        assert watch.progress == pytest.approx(0.45)
    assert watch.progress == pytest.approx(0.6)
    with watch.share(0.6, 1.0), watch.part("texture", 0.0, 1.0, Job(0.25)):
        assert watch.progress == pytest.approx(0.7)
    with watch.part("alone", 0.0, 1.0, Job(0.25)):
        assert watch.progress == pytest.approx(0.25)


def test_cancel_reaches_the_job_and_every_later_part():
    watch, job = Watch(), Job()
    with watch.part("one", 0, 1, job):
        watch.cancel()
    assert job.cancelled
    with pytest.raises(Stopped), watch.part("two", 0, 1, Job()):
        pytest.fail("it was cancelled before")
    with pytest.raises(Stopped):
        watch.poll()


def test_a_task_brings_its_result():
    task = Task(lambda watch: 42)
    assert task.wait(10) is Status.DONE
    assert task.result == 42


def test_a_stopped_task_has_the_status_stopped():
    begun = threading.Event()

    def work(watch):
        begun.set()
        while True:
            watch.poll()

    task = Task(work)
    assert begun.wait(10)
    assert task.wait(0.01) is Status.RUNNING
    task.watch.cancel()
    assert task.wait(10) is Status.STOPPED


def test_a_task_that_fails_keeps_the_reason():
    task = Task(lambda watch: 1 // 0)
    assert task.wait(10) is Status.FAILED
    assert isinstance(task.error, ZeroDivisionError)


def test_time_left_is_described_once_it_is_known():
    now, go, job = [0.0], threading.Event(), Job(0.25)

    def work(watch):
        with watch.part("flooding", 0.0, 1.0, job):
            go.wait(10)

    task = Task(work, clock=lambda: now[0])
    while task.watch.stage != "flooding":
        pass
    assert task.seconds_left() is None
    now[0] = 2.0
    assert task.seconds_left() == pytest.approx(6.0)
    assert task.describe() == "Flooding 25%, 6 s left"
    job.progress = 0.998
    assert task.describe() == "Flooding 99%, 1 s left", "100 % is the end"
    go.set()
    assert task.wait(10) is Status.DONE
