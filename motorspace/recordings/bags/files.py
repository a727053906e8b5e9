"""The files of a bag: a single one, or those in a ROS 2 folder with what its metadata count."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.recordings.bags import mcap, ros1, sqlite
from motorspace.recordings.bags.container import INSTALL, ZSTD, Contents, Raw, report_count
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.text import read_bytes

METADATA = "metadata.yaml"
LARGEST_METADATA = 4 * 2**20

ENDINGS = (".db3", ".mcap")

CONTAINERS = {ros1.MAGIC: ros1.messages, sqlite.MAGIC: sqlite.messages, mcap.MAGIC: mcap.messages}
"""What reads a file, by its first bytes."""


def messages(path: Path, contents: Contents, faults: Faults) -> Iterator[Raw]:
    """Every message that is wanted, file by file.

    Args:
        path: A bag, or a folder of ROS 2 bags.
        contents: Is filled with topics and counts.
        faults: Takes what is broken, and counts that differ from the bag's own.
    """
    if not path.exists():
        raise UserError("there is no such file", where=path, remedy="check the path")
    paths, claimed = bag_files(path, faults)
    for part in paths:
        head = read_bytes(part, 16)
        known = [read for magic, read in CONTAINERS.items() if head.startswith(magic)]
        if known:
            yield from known[0](part, contents, faults)
        else:
            faults.add(_unknown(part, head))
    # What the files' own account already said is not said twice.
    contents.claimed = Counter({t: n for t, n in claimed.items() if contents.claimed[t] != n})
    report_count(path, contents, faults)


def bag_files(path: Path, faults: Faults) -> tuple[list[Path], Counter[str]]:
    """The files of a bag, in order, and its metadata's number of messages of each topic.

    Metadata are read from the folder that is given, or from beside a file that they name alone.
    """
    folder = path if path.is_dir() else path.parent
    described = folder / METADATA
    if path.is_file() and (path.suffix not in ENDINGS or not described.is_file()):
        return [path], Counter()
    if not described.is_file():
        return _parts(path), Counter()
    names, claimed = read_metadata(described)
    if path.is_file():
        return [path], claimed if names == [path.name] else Counter()
    for name in names:
        if not (folder / name).is_file():
            missing = UserError(
                "a file of the bag is missing", where=folder / name, remedy="copy it as well"
            )
            faults.add(missing)
    return [folder / name for name in names if (folder / name).is_file()], claimed


def read_metadata(path: Path) -> tuple[list[str], Counter[str]]:
    """The names of a bag's files, without folders, and its number of messages by topic.

    Raises `UserError` for metadata that are no such thing.
    """
    try:
        found = _yaml(path)["rosbag2_bagfile_information"]
        names = [Path(str(name)).name for name in found["relative_file_paths"]]
        claimed = Counter(
            {
                str(topic["topic_metadata"]["name"]): int(topic["message_count"])
                for topic in found["topics_with_message_count"]
            }
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise _bad_metadata(path, f"{type(error).__name__}: {error}") from None
    return names, claimed


def _yaml(path: Path) -> Any:
    try:
        from ruamel.yaml import YAML, YAMLError
    except ImportError:
        raise UserError("ROS bags need rosbags", where=path, remedy=INSTALL) from None
    content = read_bytes(path, LARGEST_METADATA + 1)
    if len(content) > LARGEST_METADATA:
        raise _bad_metadata(path, "they are too large")
    try:
        return YAML(typ="safe", pure=True).load(content.decode("utf-8"))
    except (YAMLError, ValueError, RecursionError) as error:
        raise _bad_metadata(path, str(error).partition("\n")[0]) from None


def first_file(folder: Path) -> Path | None:
    """The file by which the format of a folder is recognised; None if it holds no bag."""
    return next((p for p in (folder / METADATA, *_parts(folder)) if p.is_file()), None)


def _parts(folder: Path) -> list[Path]:
    """Bags in a folder without metadata, in the order of the numbers in their names."""
    found = [path for path in folder.iterdir() if path.suffix in ENDINGS]
    return sorted(found, key=lambda p: [int(n) for n in re.findall(r"\d+", p.stem)[-1:]])


def _bad_metadata(path: Path, why: str) -> UserError:
    return UserError(
        f"the metadata cannot be read ({why})",
        where=path,
        remedy="give the .db3 or .mcap file itself from another folder, or write them anew with "
        "`ros2 bag reindex`",
    )


def _unknown(path: Path, head: bytes) -> UserError:
    if head.startswith(ZSTD):
        return UserError("the file is packed", where=path, remedy="unpack it with: zstd -d")
    return UserError(
        "it is neither a ROS bag nor an MCAP file", where=path, remedy="copy the bag again"
    )
