"""Files whole or not at all: full disks, writers at the same time, devices, links."""

import errno
import os
import resource
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from cutwise import disk

ON_LINUX = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")


def test_a_file_that_fails_half_way_leaves_the_old_one(tmp_path, monkeypatch):
    target = tmp_path / "run.nc"
    target.write_text("old")

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(disk.os, "fsync", full)
    with pytest.raises(OSError, match="No space") as fault:
        disk.write_text(target, "new")
    assert fault.value.filename == str(target)
    assert disk.in_words(fault.value).startswith("the disk is full")
    with pytest.raises(OSError, match="No space"):
        disk.write_together(tmp_path, {"run.nc": b"new", "report.html": b"new"})
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"run.nc": "old"}


@ON_LINUX
def test_a_device_is_written_to_and_not_replaced(tmp_path):
    link = tmp_path / "full"
    link.symlink_to("/dev/full")
    for write in (disk.write_text, disk.create_text):
        with pytest.raises(OSError, match="No space"):
            write(link, "text")
    assert Path("/dev/full").is_char_device()
    assert sorted(tmp_path.iterdir()) == [link]


def test_a_link_is_written_through(tmp_path):
    (tmp_path / "there").write_text("old")
    (tmp_path / "link").symlink_to("there")
    disk.write_text(tmp_path / "link", "new")
    assert (tmp_path / "there").read_text() == "new"
    assert (tmp_path / "link").is_symlink()


def test_what_is_there_is_not_created(tmp_path):
    disk.create_text(tmp_path / "a.yaml", "one")
    with pytest.raises(FileExistsError):
        disk.create_text(tmp_path / "a.yaml", "two")
    assert [file.read_text() for file in tmp_path.iterdir()] == ["one"]


def test_files_of_two_writers_never_mix(tmp_path):
    """Eight writers, each with its own pair; a reader sees a pair of one of them, or its first file alone."""
    mixed, done = [], threading.Event()

    def write(number):
        for _ in range(15):
            mine = str(number).encode() * 2000
            disk.write_together(tmp_path, {"run.nc": mine, "report.html": mine})

    def read():
        while not done.is_set():
            with disk.alone_in(tmp_path):
                seen = {file.name: file.read_bytes() for file in tmp_path.glob("r*")}
            if len(set(seen.values())) > 1:
                mixed.append(seen)

    reader = threading.Thread(target=read)
    reader.start()
    writers = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    done.set()
    reader.join()
    assert not mixed
    assert sorted(file.name for file in tmp_path.iterdir()) == ["report.html", "run.nc"]


@pytest.mark.skipif(sys.platform == "win32", reason="no fork")
def test_a_writer_killed_at_any_moment_leaves_whole_files_of_one(tmp_path):
    for stop in range(12):  # dies at its n-th call of the system that touches a file
        script = f"""
import os, sys
sys.path[:] = {sys.path!r}
from cutwise import disk
left = [{stop}]
def dying(call):
    def wrapped(*arguments, **options):
        if left[0] == 0: os._exit(9)
        left[0] -= 1
        return call(*arguments, **options)
    return wrapped
from pathlib import Path
os.fsync, os.open = dying(os.fsync), dying(os.open)
Path.replace, Path.unlink = dying(Path.replace), dying(Path.unlink)
disk.write_together(Path({str(tmp_path)!r}), {{"run.nc": b"new", "report.html": b"new"}})
"""
        disk.write_together(tmp_path, {"run.nc": b"old", "report.html": b"old"})
        subprocess.run([sys.executable, "-c", script], check=False, timeout=60)
        seen = {file.name: file.read_bytes() for file in tmp_path.iterdir() if not file.name.endswith(".part")}
        assert set(seen.values()) in ({b"old"}, {b"new"})
        assert "run.nc" in seen


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_a_file_larger_than_allowed_is_not_written(tmp_path):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match="File too large") as fault:
            disk.write_bytes(tmp_path / "run.nc", b"0" * 5000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "larger than a file may be here" in disk.in_words(fault.value)
    assert list(tmp_path.iterdir()) == []


def test_names_that_are_no_file_names():
    assert disk.file_name("..") == "unnamed"
    assert disk.file_name("a:b*c\r") == "a_b_c_"
    assert disk.file_name("Kante 1") == "Kante 1"
