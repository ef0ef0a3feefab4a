"""Which text of a source file is code: comments, docstrings and preprocessor tests are blanked."""
import ast
import io
import re
import tokenize

C_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*|\{#.*?#\}", re.DOTALL)
C_DIRECTIVE = re.compile(r"^[ \t]*#[ \t]*(?!define)\w+[^\n]*|\b_Pragma\([^\n]*", re.MULTILINE)
C_MESSAGE = re.compile(r'^[ \t]*"[^\n]*|[^\n]*const char[^\n]*|[^\n]*\(void\)\w[^\n]*', re.MULTILINE)


def code_lines(name: str, text: str) -> list[str]:
    """The lines of `text`, as long as before, with all that is not code replaced by blanks."""
    return (python_code(text) if name.endswith(".py") else c_code(text)).split("\n")


def blank(match) -> str:
    return re.sub(r"[^\n]", " ", match[0])


def c_code(text: str) -> str:
    """C, or C with template marks; messages and casts to void are no code that counts."""
    for pattern in (C_COMMENT, C_DIRECTIVE, C_MESSAGE):
        text = pattern.sub(blank, text)
    return text


def python_code(text: str) -> str:
    lines = text.split("\n")
    for first, last in docstrings(text):
        lines[first:last] = [" " * len(line) for line in lines[first:last]]
    for line, column in comments(text):
        lines[line] = lines[line][:column] + " " * (len(lines[line]) - column)
    return "\n".join(" " * len(line) if re.match(r"\s*(from|import|raise|assert)\b", line) else line
                     for line in lines)


def docstrings(text: str):
    """(first, last) line numbers, from 0, of the strings that are statements."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno - 1, node.end_lineno


def comments(text: str):
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0] - 1, token.start[1]
