"""Small texts: comments, sums and products of sizes."""
from __future__ import annotations

from ..lower.lowering import index_names


def comment(text: str) -> str:
    """User text inside a C comment: one line, printable ASCII, no comment ends."""
    plain = "".join(c if 32 <= ord(c) < 127 else "?" for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??/", "?? /").rstrip("\\")[:200]


def total(parts) -> str:
    """Sum of size texts, folded where both are numbers."""
    known = sum(int(p) for p in parts if p.isdigit())
    rest = [p for p in parts if not p.isdigit()]
    return " + ".join([*rest, *([str(known)] if known or not rest else [])])


def plus(first: str, index: str) -> str:
    if first == "0":
        return index
    return str(int(first) + int(index)) if first.isdigit() and index.isdigit() else f"{first} + {index}"


def times(k: int, n: str) -> str:
    return str(k * int(n)) if n.isdigit() else f"{k}*({n})"


def per_site(e) -> bool:
    return bool(index_names(e))
