"""Job: progress and cancelling from another thread, with the GIL released meanwhile."""

import signal
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

import isimp_engine as engine
import shapes


def test_a_new_job_has_done_nothing():
    job = engine.Job()
    assert (job.progress, job.stage, job.cancelled) == (0.0, "", False)


def test_progress_is_seen_from_another_thread_and_never_falls():
    arrays, job, seen = shapes.plane(700), engine.Job(), []
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


LONG = {
    "Mesh": lambda job: engine.Mesh(*shapes.plane(1200), job=job),
    "partition": lambda job: engine.partition(
        engine.Mesh(*shapes.bumpy(400)), engine.PartitionOptions(proxies=2000, method="lloyd", iterations=200), job=job
    ),
}


@pytest.mark.parametrize("call", LONG)
@pytest.mark.parametrize("error", [engine.Cancelled, KeyboardInterrupt])
def test_cancel_from_another_thread_and_ctrl_c_stop_a_call(call, error):
    job = engine.Job()

    def stop_once_begun():
        while job.progress == 0:
            time.sleep(0.001)
        if error is KeyboardInterrupt:
            signal.raise_signal(signal.SIGINT)
        else:
            job.cancel()

    other = threading.Thread(target=stop_once_begun)
    other.start()
    with pytest.raises(error):
        LONG[call](job)
    other.join()
    assert job.cancelled


def test_a_cancelled_job_refuses_after_the_check_of_input(cube):
    job = engine.Job()
    job.cancel()
    with pytest.raises(engine.Cancelled):
        engine.Mesh(cube.vertices, cube.triangles, job=job)
    with pytest.raises(engine.InvalidInput):
        engine.Mesh(cube.vertices, cube.triangles + 1, job=job)


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
