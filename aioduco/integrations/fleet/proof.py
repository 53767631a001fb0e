"""Proofs that an answer is of the gateway that it names: a key of each gateway, and an HMAC.

Zenoh does not tell who sent a reply, and its certificates only say that a peer belongs to the
fleet. So a gateway signs its answer to a stop by a key that it shares with the computers that ask.
The proof covers a challenge of that stop and the request, so that neither an old answer nor one to
another request passes.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from typing import TYPE_CHECKING, Final

from aioduco.integrations.fleet.settings import FleetFileError, is_name
from aioduco.models.toml_files import read_toml

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike


_CHALLENGE: Final = 32
_PURPOSE: Final = b"aioduco fleet stop 1"
#: a key of at least 16 bytes, as hexadecimal digits
_KEY: Final = re.compile(r"(?:[0-9a-fA-F]{2}){16,64}")


def challenge() -> bytes:
    """A challenge for one stop."""
    return secrets.token_bytes(_CHALLENGE)


def proof_of(key: bytes, asked: bytes, request: bytes, answer: bytes) -> bytes:
    """The proof of an answer.

    Args:
        key: key of the gateway.
        asked: the challenge.
        request: the request as it was sent.
        answer: the answer as it is sent.
    """
    parts = [hashlib.sha256(part).digest() for part in (_PURPOSE, asked, request, answer)]
    return hmac.digest(key, b"".join(parts), "sha256")


def proves(key: bytes, asked: bytes, request: bytes, answer: bytes, proof: bytes) -> bool:
    """Whether a proof is that of the answer; compared in constant time."""
    return hmac.compare_digest(proof_of(key, asked, request, answer), proof)


def read_keys(path: str | PathLike[str]) -> Mapping[str, bytes]:
    """Read a file of keys: a line `cell-a = "…"` for each gateway, in hexadecimal digits.

    Raises:
        FleetFileError: the file cannot be read, or is not valid; the text has no part of a key.
    """
    try:
        table = read_toml(path)
    except OSError as error:
        raise FleetFileError(f"the keys of the fleet cannot be read: {error}") from error
    except ValueError:  # its text may quote the file
        raise FleetFileError(f"{path} is no file of keys: it is no TOML") from None
    for name, key in table.items():
        if not is_name(name) or not isinstance(key, str) or _KEY.fullmatch(key) is None:
            raise FleetFileError(
                f"{path}: the key of {name!r:.80} must be 32 to 128 hexadecimal digits"
            )
    return {name: bytes.fromhex(key) for name, key in table.items()}
