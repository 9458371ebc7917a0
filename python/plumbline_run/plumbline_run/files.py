# SPDX-License-Identifier: Apache-2.0
"""What several readers need: errors, JSON with comments."""

import json
import os
from typing import Any, Union

PathLike = Union[str, 'os.PathLike[str]']


class FormatError(ValueError):
    """A file that is not what it should be; the message names it."""


def without_comments(text: str) -> str:
    """JSON without // comments, which Plumbline's files may hold; texts in quotes stay."""
    out, i, quoted = [], 0, False
    while i < len(text):
        c = text[i]
        if quoted and c == '\\':
            out.append(text[i:i + 2])
            i += 2
            continue
        if c == '"':
            quoted = not quoted
        if not quoted and text.startswith('//', i):
            end = text.find('\n', i)
            i = len(text) if end < 0 else end
            continue
        out.append(c)
        i += 1
    return ''.join(out)


def read_json(path: PathLike) -> Any:
    with open(path, encoding='utf-8', errors='replace') as file:
        text = file.read()
    try:
        return json.loads(text)
    except ValueError:
        pass
    try:
        return json.loads(without_comments(text))
    except ValueError as error:
        raise FormatError("'%s' is not valid JSON: %s" % (os.fspath(path), error)) from None
