"""The sidebar: docs/index.md is a plain list of links under headings, and that is its order.

A page that nobody has linked there yet joins those of its folder, or comes last.
"""

import posixpath
import re
from collections.abc import Iterator

from sphinx.application import Sphinx

_HEADING = re.compile(r"## (.+)")
_LINK = re.compile(r"\[([^\]]*)\]\(([^)#]+)\.md\)")


def add_contents(app: Sphinx, docname: str, source: list[str]) -> None:
    """Append to the root page a hidden table of contents for each of its sections."""
    if docname != app.config.root_doc:
        return
    top = posixpath.dirname(docname)
    sections = dict(_linked(source[0], top))
    listed = {docname}.union(*sections.values())
    # The section of each folder below that of the root page; the last is for what is left.
    homes = {
        posixpath.dirname(page): name for name, pages in sections.items() for page in pages
    } | {top: "More"}
    # The pages below the one of the API are listed there.
    others = (page for page in app.project.docnames if not page.startswith(f"{top}/api/"))
    for page in sorted(set(others) - listed):
        home = homes.get(posixpath.dirname(page), "More")
        sections.setdefault(home, {})[page] = ""
    for name, pages in sections.items():
        entries = [f"{label} </{page}>" if label else f"/{page}" for page, label in pages.items()]
        source[0] += _toctree(name, entries)


def _linked(text: str, folder: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield each heading of second order, and by page the names of the links in the text below."""
    rest = _HEADING.split(text)[1:]
    for name, body in zip(rest[::2], rest[1::2], strict=True):
        yield (
            name,
            {
                posixpath.normpath(posixpath.join(folder, page)): label
                for label, page in _LINK.findall(body)
            },
        )


def _toctree(caption: str, entries: list[str]) -> str:
    lines = "\n".join(entries)
    return f"\n\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{lines}\n```\n"
