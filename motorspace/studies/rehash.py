"""Give results the hashes that their configurations have today.

    python -m motorspace.studies.rehash results

For when a setting is new whose default is what was done before: the old configurations, which
lack it, are read as having the default. Whoever changes what a default does must not run this,
since results of the old one would then pass for results of the new one.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

from motorspace._files import write_atomically
from motorspace.running.store import CONFIGS, read_configs, read_lines


def rehash(folder: Path) -> int:
    """Rewrite the results in a folder.

    Args:
        folder: Holds STUDY.jsonl for each study, and the configurations.

    Returns:
        How many configurations have another hash than before.

    Raises:
        UserError: For a configuration that cannot be read any more.
    """
    from motorspace.training.config import config_from_json

    known = {
        old: config_from_json(value, where=folder / CONFIGS)
        for old, value in read_configs(folder).items()
    }
    new = {old: config.hash() for old, config in known.items()}
    for path in sorted(folder.glob("*.jsonl")):
        if path.name != CONFIGS:
            lines = read_lines(path)
            _write(path, [replace(line, config=new[line.config]).as_line() for line in lines])
    described = ({new[old]: config.as_json()} for old, config in known.items())
    _write(folder / CONFIGS, [json.dumps(config) for config in described])
    return sum(old != hashed for old, hashed in new.items())


def _write(path: Path, lines: list[str]) -> None:
    write_atomically(path, "".join(f"{line}\n" for line in lines).encode())


if __name__ == "__main__":
    changed = rehash(Path(sys.argv[1]))
    print(f"{changed} configurations have another hash than before")
