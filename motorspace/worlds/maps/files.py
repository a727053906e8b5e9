"""Files of maps, read with a limit to their size."""

from pathlib import Path

from motorspace._errors import UserError

LARGEST = 64 * 2**20
"""Bytes of the largest map that is written as text."""


def map_text(path: Path) -> str:
    """The text of a map. Raises `UserError` for a file that is missing, too large or no text."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no such file or directory"
        raise UserError(
            f"the map cannot be read ({reason})", where=path, remedy="check the path"
        ) from None
    if len(content) > LARGEST:
        raise UserError(
            f"the map is larger than {LARGEST // 2**20} MiB", where=path, remedy="cut out a part"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UserError(
            "the map is not UTF-8 text", where=path, remedy="save it as UTF-8"
        ) from None
