"""The sidebar: docs/index.md is a plain list of links under headings, and that is its order.

A page that nobody has linked there yet comes last, instead of failing the build.
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
    sections = dict(_linked(source[0], posixpath.dirname(docname)))
    listed = {docname}.union(*sections.values())
    for name, pages in sections.items():
        source[0] += _toctree(name, [f"{label} </{page}>" for page, label in pages.items()])
    # The pages below the one of the API are listed there.
    others = (page for page in app.project.docnames if not page.startswith("docs/api/"))
    if rest := sorted(page for page in others if page not in listed):
        source[0] += _toctree("More", [f"/{page}" for page in rest])


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
