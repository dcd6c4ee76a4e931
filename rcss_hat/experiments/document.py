"""A document of headings, paragraphs, tables and figures, written as Markdown and as one self-contained HTML page."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import ClassVar

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from matplotlib import rc_context
from matplotlib.figure import Figure

from rcss_hat.experiments.figures import save_figure
from rcss_hat.system.files import write_text

MARKUP = ((re.compile(r"\*\*(.+?)\*\*"), r"<strong>\1</strong>"), (re.compile(r"`(.+?)`"), r"<code>\1</code>"))
"""What titles, paragraphs, captions and cells may have of Markdown."""


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading of level 1, 2 or 3."""

    text: str
    level: int = 2
    kind: ClassVar[str] = "heading"


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Text; ``**bold**`` and ```code``` are understood."""

    text: str
    kind: ClassVar[str] = "paragraph"


@dataclass(frozen=True, slots=True)
class TableBlock:
    """A table of texts.

    Attributes
    ----------
    frame : DataFrame
        Columns are headings; the index is not shown.
    prose : bool
        Cells hold sentences rather than numbers.
    name : str
        Of the CSV file; none when empty.
    """

    frame: pd.DataFrame
    prose: bool = False
    name: str = ""
    kind: ClassVar[str] = "table"

    @property
    def columns(self) -> list[str]:
        """Headings."""
        return [str(column) for column in self.frame.columns]

    @property
    def rows(self) -> list[list[str]]:
        """Cells, as texts."""
        rows: list[list[str]] = self.frame.astype(str).to_numpy().tolist()
        return rows


@dataclass(frozen=True, slots=True)
class FigureBlock:
    """A figure with its caption; ``name`` is that of its files."""

    figure: Figure
    name: str
    caption: str
    kind: ClassVar[str] = "figure"


@dataclass(frozen=True, slots=True)
class Code:
    """Text as it stands."""

    text: str
    kind: ClassVar[str] = "code"


Block = Heading | Paragraph | TableBlock | FigureBlock | Code


def pages_in(folder: Path) -> list[Path]:
    """Return the pages that a document has in a folder: Markdown and HTML."""
    return [folder / "report.md", folder / "report.html"]


@dataclass(slots=True)
class Document:
    """Blocks in order."""

    title: str
    blocks: list[Block] = field(default_factory=list)

    def add(self, *blocks: Block) -> None:
        """Append blocks."""
        self.blocks.extend(blocks)

    def save(self, folder: Path) -> list[Path]:
        """Write ``report.md``, ``report.html``, ``tables/*.csv``, ``figures/*.png`` and ``figures/*.svg``.

        Returns
        -------
        list of Path
            The two pages.
        """
        (folder / "figures").mkdir(parents=True, exist_ok=True)
        pictures: dict[str, str] = {}
        for block in self.blocks:
            if isinstance(block, FigureBlock):
                save_figure(block.figure, folder / "figures" / f"{block.name}.png")
                pictures[block.name] = svg_text(block.figure, block.name)
                write_text(folder / "figures" / f"{block.name}.svg", pictures[block.name])
            elif isinstance(block, TableBlock) and block.name:
                text = block.frame.to_csv(index=False, lineterminator="\n").replace("**", "")
                write_text(folder / "tables" / f"{block.name}.csv", text)
        pages = pages_in(folder)
        write_text(pages[0], self.to_markdown())
        write_text(pages[1], self.to_html(pictures))
        return pages

    def to_markdown(self) -> str:
        """Return the document as Markdown; figures are links to ``figures/NAME.png``."""
        return "\n\n".join([f"# {self.title}", *map(_markdown, self.blocks)]) + "\n"

    def to_html(self, pictures: dict[str, str]) -> str:
        """Return the document as one HTML page that needs nothing else.

        Parameters
        ----------
        pictures : dict of str to str
            SVG by name of the figure.
        """
        page = _environment().get_template("document.html")
        return page.render(title=self.title, blocks=self.blocks, pictures=pictures)


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("rcss_hat.experiments"),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    made.filters["inline"] = _inline
    return made


def svg_text(figure: Figure, name: str) -> str:
    """Return a figure as SVG, the same text for the same figure; identifiers begin with what is unique to ``name``."""
    buffer = io.StringIO()
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    # Several figures share a page, so the identifiers that Matplotlib numbers need a prefix.
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    return re.sub(r'href="#', f'href="#{name}-', text)


def _markdown(block: Block) -> str:
    if isinstance(block, Heading):
        return f"{'#' * block.level} {block.text}"
    if isinstance(block, Paragraph):
        return block.text
    if isinstance(block, Code):
        return f"```text\n{block.text}\n```"
    if isinstance(block, FigureBlock):
        return f"![{block.caption}](figures/{block.name}.png)\n\n*{block.caption}*"
    align = ["---"] + ["---" if block.prose else "---:"] * (len(block.frame.columns) - 1)
    rows = [block.columns, align, *block.rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows)


def _inline(text: object) -> Markup:
    """Escape a text for HTML, except for what `MARKUP` makes of it."""
    escaped = str(escape(text))
    for pattern, element in MARKUP:
        escaped = pattern.sub(element, escaped)
    return Markup(escaped)
