import errno
import os
from pathlib import Path

import pytest

from fenics_defo.errors import DefoError
from fenics_defo.runtime import atomic_path, check_writable


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def test_content_appears_under_the_name_only_at_the_end(tmp_path: Path) -> None:
    target = tmp_path / "picture.png"
    with atomic_path(target) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".png"
        temporary.write_text("new")
        assert not target.exists()
    assert target.read_text() == "new"
    assert names(tmp_path) == ["picture.png"]


@pytest.mark.parametrize("exception", [ValueError, KeyboardInterrupt, SystemExit])
def test_old_file_survives_any_exception(tmp_path: Path, exception: type[BaseException]) -> None:
    target = tmp_path / "modes.npz"
    target.write_text("old")

    def interrupted() -> None:
        with atomic_path(target) as temporary:
            temporary.write_text("half")
            raise exception

    with pytest.raises(exception):
        interrupted()
    assert target.read_text() == "old"
    assert names(tmp_path) == ["modes.npz"]


def test_full_disk_is_one_sentence(tmp_path: Path) -> None:
    def full() -> None:
        with atomic_path(tmp_path / "modes.npz"):
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(DefoError, match=r"modes\.npz: writing stopped: No space left on device"):
        full()
    assert names(tmp_path) == []


def test_other_os_errors_of_the_block_pass_unchanged(tmp_path: Path) -> None:
    def reads_what_is_not_there() -> None:
        with atomic_path(tmp_path / "a.npz"):
            (tmp_path / "absent").read_text()

    with pytest.raises(FileNotFoundError):
        reads_what_is_not_there()
    assert names(tmp_path) == []


def test_link_stays_and_permissions_are_kept(tmp_path: Path) -> None:
    target, link = tmp_path / "real.npz", tmp_path / "link.npz"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    with atomic_path(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert target.stat().st_mode & 0o777 == 0o640


def test_new_file_obeys_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with atomic_path(tmp_path / "a.npz"):
            pass
    finally:
        os.umask(before)
    assert (tmp_path / "a.npz").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("absent/a.npz", "does not exist; create it first"),
        ("", "is a folder; name a file inside it"),
        ("file/a.npz", "does not exist"),
        ("a" * 300 + ".npz", "File name too long"),
        ("fifo", "is not a regular file"),
    ],
)
def test_places_that_cannot_be_written_are_refused_up_front(
    tmp_path: Path, name: str, message: str
) -> None:
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "fifo")
    before = names(tmp_path)
    with pytest.raises(DefoError, match=message):
        check_writable(tmp_path / name)
    assert names(tmp_path) == before


def test_devices_are_never_replaced() -> None:
    with pytest.raises(DefoError, match="not a regular file"):
        check_writable("/dev/null")
    assert Path("/dev/null").is_char_device()


def test_read_only_file_system_is_refused() -> None:
    # /proc refuses new files to everyone, root included, unlike a folder without permissions.
    with pytest.raises(DefoError, match="no file can be written in '/proc'"):
        check_writable("/proc/modes.npz")


def test_empty_name_is_refused() -> None:
    with pytest.raises(DefoError, match="needs a name"):
        check_writable("")


def test_check_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "old.npz").write_text("old")
    check_writable(tmp_path / "new.npz")
    check_writable(tmp_path / "old.npz")
    assert names(tmp_path) == ["old.npz"]
    assert (tmp_path / "old.npz").read_text() == "old"
