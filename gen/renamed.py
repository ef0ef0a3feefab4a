"""Words of earlier versions, each with the present one: an error that meets the old word names the new."""
from __future__ import annotations

KEYS = {"section": "period"}                # of a spec
OPTIONS = {"--section": "--period", "--with": "--features", "--of": "--family"}     # of the command
KEYWORDS = {"values": "parameters", "section": "period", "name": "run", "starts": "start", "folder": "out"}
ATTRIBUTES = {"values_in": "parameters"}
META = {"section": "period", "values": "parameters"}        # of the metadata of a result; files that have the old ones are read


def now(word: str, table: dict, known) -> str | None:
    """What `word` is called now, if that is among the words that are known here."""
    return table[word] if table.get(word) in known and word not in known else None


def up_to_date(meta: dict) -> dict:
    """Metadata with the present names of their keys."""
    return {now(key, META, META.values()) or key: value for key, value in meta.items()}
