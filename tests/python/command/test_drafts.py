"""Files appear whole or not at all."""

import os

import pytest

from isimp_engine.drafts import draft_of, whole


def test_a_file_is_replaced_when_all_is_written_and_keeps_its_permissions(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("old")
    path.chmod(0o640)
    with whole(path) as draft:
        draft.write_text("new")
        assert (path.read_text(), draft.suffix, draft.parent) == ("old", ".obj", tmp_path)
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o640)
    assert os.listdir(tmp_path) == ["a.obj"]


def failing(draft):
    draft.write_text("half")
    raise OSError(28, "full")


def test_a_failure_leaves_nothing_but_the_old_file(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("old")
    with pytest.raises(OSError, match="full"), whole(path) as draft:
        failing(draft)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.obj"]


def test_links_stay_and_devices_are_written_to_directly(tmp_path):
    (tmp_path / "real.obj").write_text("old")
    (tmp_path / "link.obj").symlink_to("real.obj")
    with whole(tmp_path / "link.obj") as draft:
        draft.write_text("new")
    assert (tmp_path / "link.obj").is_symlink()
    assert (tmp_path / "real.obj").read_text() == "new"
    os.mkfifo(tmp_path / "pipe")
    assert draft_of(tmp_path / "pipe") == (tmp_path / "pipe", tmp_path / "pipe")
