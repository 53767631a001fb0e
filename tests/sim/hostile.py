"""A fuzzer of the server: a seeded mutator of valid calls, and connections that send what it makes.

Two kinds of frames:

- *odd* ones are whole messages whose values make no sense: numbers that are none, lists of other
  lengths, texts that are no names. Each has to be answered, in order, and none by an error that
  nobody meant.
- *broken* ones are no messages: cut off, of other types, with sizes that claim gigabytes, nested
  too deep, or noise. Their connection may be closed; the server goes on.

A connection sends some odd frames and a broken one as the last, and reads until the server
closes; now and then it first enables the arm again, since some frames switch it off. Meanwhile a
probe calls on a connection of its own, and is timed; it also ends what the others have begun.
"""

from __future__ import annotations

import itertools
import random
import socket
import struct
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from thriftpy2.thrift import TType

from aioduco._wire import idl
from aioduco._wire.messages import Inbox, Message, MessageType

from .raw import RawClient, encode

#: the calls that end what is tried
SPARED = frozenset(("shutdown", "restart"))
ODD_NUMBERS = (float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 5e-324, 0.0, -0.0, 1e-9)
_SIZES = (-(2**31), -1, 2**16 + 1, 2**20 + 1, 2**30, 2**31 - 1)
_BATCH = 12
_SENDERS = 4  # at once
_ENABLED_EVERY = 10  # batches
_ENABLED = 6
#: how long an answer may take: a motion ends by its own or by the probe's stop [s]
_PATIENCE = 30.0
_RESET = b"\x01\x00\x00\x00\x00\x00\x00\x00"  # linger for no time: a reset instead of an end


class Mutator:
    """Makes frames, the same ones from the same seed."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._functions = [f for name, f in idl.functions().items() if name not in SPARED]

    def odd(self, seqid: int) -> bytes:
        """A whole call with values of the right types and no sense."""
        function = self._random.choice(self._functions)
        spec = function.args.thrift_spec
        values = {
            of[1]: self._value(of[0], of[2] if len(of) > 3 else None)
            for of in spec.values()
            if self._random.random() < 0.9
        }
        return encode(function.name, seqid, **values)

    def broken(self, seqid: int) -> bytes:
        """Bytes that are no message, most of which begin like one."""
        frame = bytearray(self.odd(seqid))
        draw = self._random
        match draw.randrange(8):
            case 0:  # cut off
                del frame[draw.randrange(1, len(frame)) :]
            case 1:  # some bits are others
                for _ in range(draw.randrange(1, 9)):
                    frame[draw.randrange(len(frame))] ^= 1 << draw.randrange(8)
            case 2:  # a size that is a lie
                at = draw.randrange(max(1, len(frame) - 4))
                frame[at : at + 4] = struct.pack(">i", draw.choice(_SIZES))
            case 3:  # noise, in the middle of a call
                at = draw.randrange(len(frame))
                frame[at:at] = draw.randbytes(draw.randrange(1, 64))
            case 4:  # nothing but noise
                frame = bytearray(draw.randbytes(draw.randrange(1, 200)))
            case 5:  # nested without an end
                frame[-1:] = b"\x0c\x00\x01" * draw.randrange(1, 2000)
            case 6:  # a text, list, set or map of gigabytes
                kind = draw.choice((b"\x0b", b"\x0f\x00\x01\x0b", b"\x0e\x00\x01\x08", b"\x0d"))
                frame[-1:] = kind[:1] + b"\x00\x01" + kind[3:]
                frame += struct.pack(">i", draw.choice(_SIZES)) * 2
            case _:  # two calls in each other
                other = self.odd(seqid)
                at = draw.randrange(len(frame))
                frame[at:] = other[draw.randrange(len(other)) :]
        return bytes(frame)

    def _value(self, kind: int, extra: Any) -> Any:
        draw = self._random
        if kind == TType.BOOL:
            return draw.random() < 0.5
        if kind in (TType.BYTE, TType.I16, TType.I32, TType.I64):
            bits = {TType.BYTE: 7, TType.I16: 15, TType.I32: 31, TType.I64: 63}[kind]
            return draw.choice((0, 1, 2, 3, 6, -1, 2**bits - 1, -(2**bits), draw.getrandbits(bits)))
        if kind == TType.DOUBLE:
            return draw.choice((draw.uniform(-1, 1), draw.uniform(0, 100), *ODD_NUMBERS))
        if kind == TType.STRING:
            texts = ("", "default", "a", "no such name", "急停", "../..", "x" * draw.randrange(300))
            return draw.choice(texts)
        if kind == TType.LIST:
            inner, more = extra if isinstance(extra, tuple) else (extra, None)
            length = draw.choice((0, 1, 3, 6, 6, 6, 6, 7, draw.randrange(60)))
            if inner == TType.DOUBLE and draw.random() < 0.5:
                return [draw.uniform(-1, 1) for _ in range(length)]
            return [self._value(inner, more) for _ in range(length)]
        values = {
            of[1]: self._value(of[0], of[2] if len(of) > 3 else None)
            for of in extra.thrift_spec.values()
        }
        return extra(**values)


@dataclass
class Outcome:
    """What came of it.

    Attributes:
        frames: sent, by kind.
        answers: by kind.
        wrong: what must not be: calls without an answer or out of order, errors in the handlers,
            a probe that is not served.
        probes: how long each call of the probe took [s].
        longest: the longest that a connection had to wait for its end [s].
        enabled: how often the arm was enabled before a batch.
    """

    frames: Counter[str] = field(default_factory=Counter)
    answers: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    probes: list[float] = field(default_factory=list)
    longest: float = 0.0
    enabled: int = 0


class Fuzzer:
    """Sends frames on several connections at once.

    Args:
        port: of the server, on loopback.
        frames: how many in all.
        seed: of the frames.
    """

    def __init__(self, port: int, frames: int, seed: int = 1) -> None:
        self._port = port
        self._numbers = itertools.count(0, _BATCH)
        self._frames = frames
        self._seed = seed
        self._lock = threading.Lock()
        #: held while the arm is switched on, which the other connections' frames would undo
        self._alone = threading.Lock()
        self._under_way = 0
        self._nobody = threading.Condition(self._lock)
        self._done = threading.Event()
        self.outcome = Outcome()

    def run(self) -> Outcome:
        """Send all of them, and return what came of it."""
        senders = [threading.Thread(target=self._send) for _ in range(_SENDERS)]
        probe = threading.Thread(target=self._probe)
        for thread in (*senders, probe):
            thread.start()
        for thread in senders:
            thread.join()
        self._done.set()
        probe.join()
        return self.outcome

    def _send(self) -> None:
        try:
            while (number := next(self._numbers)) < self._frames:
                # A seed of each batch: what is sent does not depend on which thread sends it.
                self._batch(Mutator(self._seed * 1_000_003 + number), number)
        except Exception as exc:
            self.outcome.wrong.append(f"a sender ended: {exc!r}")

    def _batch(self, mutator: Mutator, number: int) -> None:
        odd = min(_BATCH, self._frames - number) - 1
        frames = [mutator.odd(seqid) for seqid in range(1, odd + 1)]
        frames.append(mutator.broken(odd + 1))
        with self._alone:
            if number % (_ENABLED_EVERY * _BATCH) == 0:
                with self._nobody:
                    self._nobody.wait_for(lambda: self._under_way == 0)
                self._enable()
            with self._lock:
                self._under_way += 1
        began = time.perf_counter()
        try:
            answers, ended = self._exchange(b"".join(frames), reset=number % (7 * _BATCH) == 0)
        finally:
            with self._nobody:
                self._under_way -= 1
                self._nobody.notify_all()
        took = time.perf_counter() - began
        with self._lock:
            outcome = self.outcome
            outcome.frames.update(odd=odd, broken=1)
            outcome.longest = max(outcome.longest, took)
            outcome.answers.update(answer.kind.name.lower() for answer in answers)
            seqids = [answer.seqid for answer in answers[:odd]]
            outcome.wrong += [
                f"batch {number}: {answer.name}: {answer.body!r}"
                for answer in answers[:odd]
                if answer.kind is not MessageType.REPLY and b" is not simulated" not in answer.body
            ]
            if ended and seqids != list(range(1, odd + 1)):
                outcome.wrong.append(f"batch {number}: answers of {seqids}, of {odd} calls")

    def _enable(self) -> None:
        """Switch the arm on: else most of what follows would find one that does not move."""
        with RawClient(self._port, timeout=_PATIENCE) as client:
            for name in ("power_off", "power_on", "enable"):
                client.call(name, block=True)
            enabled = client.call("get_robot_state")[0] == _ENABLED
        with self._lock:
            self.outcome.enabled += enabled

    def _exchange(self, data: bytes, *, reset: bool) -> tuple[list[Message], bool]:
        """Send, and read until the server closes; with `reset`, leave without a word instead."""
        inbox = Inbox()
        answers: list[Message] = []
        with socket.create_connection(("127.0.0.1", self._port), timeout=_PATIENCE) as sock:
            try:
                sock.sendall(data)
                if reset:
                    sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
                    return [], False
                sock.shutdown(socket.SHUT_WR)
                while received := sock.recv(1 << 16):
                    answers += inbox.messages(received)
            except ConnectionError:
                # Bytes that came after the broken frame make the server's end a reset, and what
                # it had sent may be gone with it.
                return answers, False
        return answers, True

    def _probe(self) -> None:
        try:
            with RawClient(self._port, timeout=_PATIENCE) as client:
                for number in itertools.count():
                    began = time.perf_counter()
                    state = client.call("get_robot_state")
                    self.outcome.probes.append(time.perf_counter() - began)
                    assert len(state) == 4
                    if number % 10 == 0:
                        client.call("stop", block=False)  # else a call may wait for ever
                    if self._done.wait(0.01):
                        return
        except Exception as exc:
            self.outcome.wrong.append(f"the probe was not served: {exc!r}")


def percentiles(seconds: list[float]) -> dict[str, float]:
    """Milliseconds: p50, p99 and the longest."""
    ordered = sorted(seconds)
    at = {"p50": len(ordered) // 2, "p99": len(ordered) * 99 // 100, "max": -1}
    return {name: round(ordered[index] * 1e3, 3) for name, index in at.items()}
