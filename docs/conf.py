"""The site of these pages, as `make site` builds it: Markdown by MyST, equations as MathML, so that nothing is fetched from a network."""
from docutils import nodes
from latex2mathml.converter import convert
from pygments.lexers.configs import TOMLLexer
from pygments.lexers.special import TextLexer
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from smidgen.read.catalogue import catalogue, piece
from smidgen.version import __version__

project, author, release = "smidgen", "the smidgen authors", __version__
copyright = author
extensions = ["myst_parser", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = f"smidgen {release}"
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
highlight_language, default_role = "none", "code"
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4
autodoc_member_order = "bysource"
autodoc_class_signature = "separated"


def mathml(node, display):
    """An equation as MathML, which browsers typeset by themselves."""
    try:
        return convert(node.astext().replace(r"\lvert", r"\left|").replace(r"\rvert", r"\right|"), display=display)
    except Exception as error:                              # the errors of the converter have no common class
        logging.getLogger(__name__).warning("equation %r: %r", node.astext(), error, location=node)
        return ""


def inline(writer, node):
    writer.body.append(mathml(node, "inline"))
    raise nodes.SkipNode


def displayed(writer, node):
    writer.body.append(writer.starttag(node, "div", CLASS="math") + mathml(node, "block") + "</div>\n")
    raise nodes.SkipNode


class Pieces(SphinxDirective):
    """A table of the pieces that come with smidgen."""

    def run(self):
        rows = ["| piece | what it is, and its source | arguments | law |", "|---|---|---|---|"]
        for one in map(piece, catalogue()):
            cells = (f"`{one.name}`", f"{one.title}. {one.source}", ", ".join(f"`{argument}`" for argument in one.arguments), one.law)
            rows.append("| " + " | ".join(cell.replace("|", r"\|").replace("*", r"\*") for cell in cells) + " |")
        return self.parse_text_to_nodes("\n".join(rows))


def plain(app, what, name, obj, options, lines):
    """Docstrings are plain text: |w| is a length there, not a substitution."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app):
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.add_directive("pieces", Pieces)
    app.connect("autodoc-process-docstring", plain)
    for name in ("toml-piece", "toml-test"):
        app.add_lexer(name, TOMLLexer)
    for name in ("output", "mermaid"):
        app.add_lexer(name, TextLexer)
