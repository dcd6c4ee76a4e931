"""The study's own pages: texts, questions, the end, and the door of the open link. The game's page is the viewer's."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader
from markdown_it import MarkdownIt
from markupsafe import Markup

from rcss_hat.studies.answers import NotAnswered
from rcss_hat.studies.parts import EndStep, PeopleStudy, QuestionsStep, Text, TextStep, said
from rcss_hat.studies.progress import Progress
from rcss_hat.studies.wording import wording
from rcss_hat.viewer.pagefiles import HEADERS as VIEWER_HEADERS

HEADERS = {
    **VIEWER_HEADERS,
    "Content-Security-Policy": VIEWER_HEADERS["Content-Security-Policy"].replace(
        "form-action 'none'", "form-action 'self'"
    ),
    # Without any referrer browsers call the origin of a form "null", as those of strangers do.
    "Referrer-Policy": "same-origin",
}
_TYPES = {".css": "text/css", ".js": "text/javascript"}


@cache
def _templates() -> Environment:
    return Environment(loader=PackageLoader("rcss_hat.studies"), autoescape=True, trim_blocks=True, lstrip_blocks=True)


@cache
def own_files() -> dict[str, tuple[bytes, str]]:
    """Read the scripts and styles of these pages: name to (content, content type)."""
    found = {}
    for file in (files("rcss_hat.studies") / "static").iterdir():
        suffix = "." + file.name.rpartition(".")[2]
        if suffix in _TYPES:
            found[file.name] = file.read_bytes(), _TYPES[suffix]
    return found


def markdown(text: str) -> Markup:
    """Make HTML of Markdown; HTML in it is shown, not obeyed."""
    return Markup(MarkdownIt("commonmark", {"html": False}).enable("table").render(text))


class Pages:
    """The pages of one study.

    Parameters
    ----------
    study : PeopleStudy
    """

    def __init__(self, study: PeopleStudy) -> None:
        self.study = study

    def step(
        self,
        progress: Progress,
        code: str,
        wrong: Mapping[str, NotAnswered] | None = None,
        given: Mapping[str, list[str]] | None = None,
        trouble: str | None = None,
    ) -> str:
        """Make the page of the step that a participant is at.

        Parameters
        ----------
        progress : Progress
        code : str
            For the end.
        wrong, given : mapping, optional
            What is wrong with a form that was sent, and what was in it.
        trouble : str, optional
            Name of the words that say what went wrong.
        """
        current = progress.current
        step = current.step
        language = self.language(progress)
        words = wording(language)

        def tell(text: Text) -> str:
            return said(text, language, self.study.language)

        text = step.text if isinstance(step, TextStep | QuestionsStep | EndStep) else ""
        return self._page(
            "step.html",
            language,
            position=progress.plan.index(current) + 1,
            steps=len(progress.plan),
            name=current.name,
            heading=tell(step.title),
            text=markdown(words["stopped"] if progress.stopped else tell(text)),
            agree=tell(step.agree) if isinstance(step, TextStep) else "",
            questions=step.question if isinstance(step, QuestionsStep) else (),
            ended=isinstance(step, EndStep),
            code=code if isinstance(step, EndStep) and step.code and not progress.stopped else "",
            wrong={name: words[p.code].format(**p.values) for name, p in (wrong or {}).items()},
            given=given or {},
            trouble=words[trouble] if trouble else "",
            tell=tell,
        )

    def join(self, language: str, begun: bool) -> str:
        """Make the page behind the open link; ``begun``: somebody has begun on this computer."""
        return self._page("join.html", language, begun=begun)

    def message(self, which: str, language: str | None = None) -> str:
        """Make a page that says one thing."""
        return self._page("message.html", language or self.study.language, message=which)

    def language(self, progress: Progress) -> str:
        """Return the language a participant reads."""
        chosen = progress.language
        return chosen if chosen in self.study.languages else self.study.language

    def _page(self, template: str, language: str, **values: Any) -> str:
        study = self.study
        names = {code: wording(code)["language"] if code != study.language else "" for code in study.languages}
        names[study.language] = wording(study.language)["language"]
        return (
            _templates()
            .get_template(template)
            .render(
                title=said(study.title, language, study.language),
                language=language,
                languages=names if len(names) > 1 else {},
                words=wording(language),
                **values,
            )
        )


def lab_page(study: PeopleStudy) -> str:
    """Make the experimenter's page; she reads English."""
    title = said(study.title, study.language, study.language)
    return _templates().get_template("lab.html").render(title=title, language="en")
