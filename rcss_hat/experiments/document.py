"""A document of headings, paragraphs, tables and figures, written as Markdown and as one self-contained HTML page."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure

from rcss_hat.experiments.figures import save_figure
from rcss_hat.hat.files import write_text

STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #ffffff; --line: #d9d9d9; --soft: #f5f5f3; --dim: #5f5f5f; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --paper: #17181a; --line: #3a3c40; --soft: #202226; --dim: #a0a0a0; }
  figure img, figure svg { background: #ffffff; border-radius: 4px; }
}
body { font: 16px/1.55 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 66rem; margin: 2.5rem auto; padding: 0 1.25rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin-bottom: .4rem; }
h2 { font-size: 1.25rem; margin-top: 2.6rem; border-bottom: 1px solid var(--line); padding-bottom: .25rem; }
h3 { font-size: 1.02rem; margin-top: 1.8rem; margin-bottom: .4rem; }
p { max-width: 48rem; }
.table { overflow-x: auto; margin: .8rem 0 1.2rem; }
table { border-collapse: collapse; font-size: .86rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { font-weight: 600; color: var(--dim); vertical-align: bottom; white-space: normal; }
td:first-child, th:first-child { text-align: left; padding-left: 0; }
table.text td { white-space: normal; text-align: left; vertical-align: top; }
table.text th { text-align: left; }
figure { margin: 1rem 0 1.6rem; }
figure svg { max-width: 100%; height: auto; }
figcaption, .note { color: var(--dim); font-size: .88rem; max-width: 48rem; }
pre { background: var(--soft); padding: .8rem 1rem; overflow-x: auto; font-size: .82rem; line-height: 1.45; }
code { font-family: ui-monospace, monospace; }
"""


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading of level 1, 2 or 3."""

    text: str
    level: int = 2


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Text; ``**bold**`` and ```code``` are understood."""

    text: str


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


@dataclass(frozen=True, slots=True)
class FigureBlock:
    """A figure with its caption; ``name`` is that of its files."""

    figure: Figure
    name: str
    caption: str


@dataclass(frozen=True, slots=True)
class Code:
    """Text as it stands."""

    text: str


Block = Heading | Paragraph | TableBlock | FigureBlock | Code


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
        pages = [folder / "report.md", folder / "report.html"]
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
        body = "\n".join(_html(block, pictures) for block in self.blocks)
        return (
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{html.escape(self.title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
            f"<h1>{_inline(self.title)}</h1>\n{body}\n</body>\n</html>\n"
        )


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
    rows = [[str(c) for c in block.frame.columns], align, *block.frame.astype(str).to_numpy().tolist()]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows)


def _html(block: Block, pictures: dict[str, str]) -> str:
    if isinstance(block, Heading):
        return f"<h{block.level}>{_inline(block.text)}</h{block.level}>"
    if isinstance(block, Paragraph):
        return f"<p>{_inline(block.text)}</p>"
    if isinstance(block, Code):
        return f"<pre><code>{html.escape(block.text)}</code></pre>"
    if isinstance(block, FigureBlock):
        caption = _inline(block.caption)
        return f'<figure role="img">\n{pictures[block.name]}\n<figcaption>{caption}</figcaption>\n</figure>'
    kind = ' class="text"' if block.prose else ""
    head = _row(list(block.frame.columns), "th")
    body = "\n".join(_row(row, "td") for row in block.frame.astype(str).to_numpy().tolist())
    return f'<div class="table"><table{kind}>\n<thead>{head}</thead>\n<tbody>\n{body}\n</tbody>\n</table></div>'


def _row(cells: Sequence[object], tag: str) -> str:
    return "<tr>" + "".join(f"<{tag}>{_inline(str(cell))}</{tag}>" for cell in cells) + "</tr>"


def _inline(text: str) -> str:
    escaped = html.escape(text, quote=False)
    escaped = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", escaped)
    return re.sub(r"`(.+?)`", r"<code>\1</code>", escaped)
