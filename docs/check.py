"""Look through the built site for what the renderer does not see: `python -m docs.check SITE`.

A picture that is not there, and anything that a page would load from the network.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

TAGS = re.compile(r"<(?:script|img|iframe|source|video|link)\b[^>]*>", re.IGNORECASE)
ADDRESS = re.compile(r"""\b(?:src|href)=["']?([^"'\s>]+)""", re.IGNORECASE)
IN_STYLES = re.compile(r"""url\(["']?([^"')]+)""", re.IGNORECASE)
NETWORK = re.compile(r"(?:https?:)?//", re.IGNORECASE)


def main(site: Path) -> None:
    """Exit with a sentence for each fault."""
    if faults := list(faults_of(site)):
        sys.exit("\n".join(faults))


def faults_of(site: Path) -> Iterator[str]:
    """A sentence for everything that a page or style would load and that is not in the site."""
    for page in sorted([*site.rglob("*.html"), *site.rglob("*.css")]):
        text = page.read_text()
        for address in _loaded(text) if page.suffix == ".html" else IN_STYLES.findall(text):
            if NETWORK.match(address):
                yield f"{page.relative_to(site)} loads {address} from the network"
            elif not _is_there(site if address.startswith("/") else page.parent, address):
                yield f"{page.relative_to(site)} loads {address}, which is not there"
        if 'class="mermaid"' in text:
            yield f"{page.relative_to(site)} has a diagram whose script is on the network"


def _loaded(text: str) -> list[str]:
    # An anchor's address is a link, but a stylesheet or a script is loaded.
    tags = [tag for tag in TAGS.findall(text) if 'rel="canonical"' not in tag]
    return [address for tag in tags for address in ADDRESS.findall(tag)]


def _is_there(folder: Path, address: str) -> bool:
    path = unquote(re.split(r"[?#]", address)[0]).lstrip("/")
    return address.startswith("data:") or not path or (folder / path).exists()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
