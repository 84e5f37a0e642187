"""Job: progress and cancelling from another thread, with the GIL released meanwhile."""

import signal
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

import isimp_engine as engine
import shapes


def big_sheet():
    return shapes.plane(700)


def test_a_new_job_has_done_nothing():
    job = engine.Job()
    assert (job.progress, job.stage, job.cancelled) == (0.0, "", False)


def test_a_finished_job_stands_at_one():
    job = engine.Job()
    engine.Mesh(*shapes.cube(), job=job)
    assert job.progress == 1.0


def test_progress_is_seen_from_another_thread_and_never_falls():
    arrays, job, seen = big_sheet(), engine.Job(), []
    done = threading.Event()

    def watch():
        while not done.is_set():
            seen.append((job.progress, job.stage))
            time.sleep(0.002)

    watcher = threading.Thread(target=watch)
    watcher.start()
    engine.Mesh(*arrays, job=job)
    done.set()
    watcher.join()
    progress = [p for p, _ in seen]
    assert progress == sorted(progress)
    assert any(0 < p < 1 for p in progress), "no step of the way was seen: the GIL was held"
    assert any(stage for _, stage in seen)


def test_cancel_from_another_thread_stops_the_call():
    arrays, job = big_sheet(), engine.Job()

    def cancel_once_begun():
        while job.progress == 0:
            time.sleep(0.001)
        job.cancel()

    canceller = threading.Thread(target=cancel_once_begun)
    canceller.start()
    with pytest.raises(engine.Cancelled):
        engine.Mesh(*arrays, job=job)
    canceller.join()
    assert job.cancelled


def test_a_cancelled_job_refuses_after_the_check_of_input(cube):
    job = engine.Job()
    job.cancel()
    with pytest.raises(engine.Cancelled):
        engine.Mesh(cube.vertices, cube.triangles, job=job)
    with pytest.raises(engine.InvalidInput):
        engine.Mesh(cube.vertices, cube.triangles + 1, job=job)


def test_ctrl_c_stops_a_long_call():
    arrays, job = shapes.plane(1200), engine.Job()

    def interrupt_once_begun():
        while job.progress == 0:
            time.sleep(0.001)
        signal.raise_signal(signal.SIGINT)

    interrupter = threading.Thread(target=interrupt_once_begun)
    interrupter.start()
    with pytest.raises(KeyboardInterrupt):
        engine.Mesh(*arrays, job=job)
    interrupter.join()
    assert job.cancelled


def test_many_threads_may_use_one_mesh(sheet):
    results = [None] * 4

    def read(i):
        results[i] = (np.array(sheet.vertices).sum(), sheet.report["faces"])

    threads = [threading.Thread(target=read, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(results)) == 1


@pytest.fixture(scope="module")
def model():
    """A scan that has a texture, with all that is made of it."""
    vertices, triangles = shapes.cube(4)
    soup = engine.TexturedSoup(vertices, triangles, colors=np.full((len(vertices), 3), 99, np.uint8))
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=8))
    return SimpleNamespace(soup=soup, mesh=mesh, part=part, poly=engine.polygonize(mesh, part))


CALLS = {
    "clean": lambda m, job, path: engine.clean(m.mesh.vertices, m.mesh.triangles, job=job),
    "partition": lambda m, job, path: engine.partition(m.mesh, engine.PartitionOptions(proxies=8), job=job),
    "polygonize": lambda m, job, path: engine.polygonize(m.mesh, m.part, job=job),
    "distances": lambda m, job, path: engine.within.scan_distances(m.mesh, m.part, m.poly, job=job),
    "convex_parts": lambda m, job, path: engine.convex_parts(m.poly, job=job),
    "merge_flat": lambda m, job, path: engine.merge_flat(m.mesh, job=job),
    "regularise": lambda m, job, path: engine.regularise(m.mesh, m.part, job=job),
    "texture": lambda m, job, path: engine.texture(
        m.mesh, m.part, m.poly, m.soup, engine.TextureOptions(size=64, occlusion=True), job=job
    ),
    "corner_sources": lambda m, job, path: engine.texturing.corner_sources(
        m.mesh, m.part, m.poly, m.soup.vertices, m.soup.triangles, job
    ),
    "write": lambda m, job, path: engine.write(path / "out.obj", m.poly, job=job),
    "read": lambda m, job, path: engine.read(path / "in.obj", job=job),
    "improve": lambda m, job, path: engine.improve(m.mesh, m.part, job=job),
    "even_borders": lambda m, job, path: engine.even_borders(m.mesh, m.part, job=job),
    "add_worst": lambda m, job, path: engine.add_worst(m.mesh, m.part, job=job),
    "merge_cheapest": lambda m, job, path: engine.merge_cheapest(m.mesh, m.part, job=job),
    "all_statistics": lambda m, job, path: engine.regions.all_statistics(m.mesh, m.part, job=job),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_cancelled_job_stops_every_call(model, name, tmp_path):
    engine.write(tmp_path / "in.obj", model.poly)
    job = engine.Job()
    CALLS[name](model, job, tmp_path)
    assert 0.95 < job.progress <= 1 or name not in ("clean", "partition", "polygonize", "texture")
    (tmp_path / "out.obj").unlink(missing_ok=True)
    job.cancel()
    with pytest.raises(engine.Cancelled):
        CALLS[name](model, job, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["in.obj"]
