"""Small texts: comments."""
from __future__ import annotations


def comment(text: str) -> str:
    """User text inside a C comment: one line, printable ASCII, no comment ends."""
    plain = "".join(c if 32 <= ord(c) < 127 else "?" for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??/", "?? /").rstrip("\\")[:200]

