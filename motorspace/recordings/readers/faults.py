"""Broken places of a file: the first one ends the reading, or all are left out and counted."""

from collections import Counter

from motorspace._errors import UserError

SHOWN = 3
"""Places that the notes name of each kind of fault."""

ASK = "or leave broken places out with skip_bad (--skip-bad)"


class Faults:
    """What is broken in a file, as its reader meets it.

    Args:
        skip: Whether to go on after a fault.
    """

    def __init__(self, skip: bool) -> None:
        self.skip = skip
        self._counts: Counter[str] = Counter()
        self._places: dict[str, list[str]] = {}

    def add(self, error: UserError) -> None:
        """Count a fault that is left out, or raise it with the remedy that it can be left out."""
        if not self.skip:
            remedy = f"{error.remedy}, {ASK}" if error.remedy else ASK.removeprefix("or ")
            raise UserError(error.what, where=error.where, remedy=remedy) from None
        self._counts[error.what] += 1
        places = self._places.setdefault(error.what, [])
        if error.where is not None and len(places) < SHOWN:
            # The notes are about one file, so its folder says nothing.
            places.append(error.where.rpartition("/")[2])

    def notes(self) -> list[str]:
        """A sentence for each kind of fault: how often it was left out, and where first."""
        written = []
        for what, count in self._counts.most_common(8):
            places = self._places[what]
            more = ", ..." * (count > len(places))
            where = f" ({'; '.join(places)}{more})" if places else ""
            written.append(f"skipped {count} broken: {what}{where}")
        if hidden := len(self._counts) - len(written):
            written.append(f"skipped broken places of {hidden} further kinds")
        return written
