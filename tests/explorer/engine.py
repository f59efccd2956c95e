"""The engine as WebAssembly, called from Python: what a page sees, without a browser."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import wasmtime


class Engine:
    """One instance of the compiled module; the names are those of its C interface."""

    def __init__(self, code: bytes) -> None:
        engine = wasmtime.Engine()
        self._store = wasmtime.Store(engine)
        linker = wasmtime.Linker(engine)
        linker.define_wasi()
        self._store.set_wasi(wasmtime.WasiConfig())
        module = wasmtime.Module(engine, code)
        self._exports = linker.instantiate(self._store, module).exports(self._store)
        self.call("_initialize")
        self.fields, self.results, self.guards = (
            self._text(self.call(f"{kind}_names")).split() for kind in ("field", "result", "guard")
        )

    def call(self, name: str, *arguments: float) -> int:
        return self._exports[name](self._store, *arguments)

    def read(self, place: int, count: int) -> np.ndarray:
        memory = self._exports["memory"].read(self._store, place, place + 8 * count)
        return np.frombuffer(memory, dtype="<f8")

    def write_row(self, row: Sequence[float]) -> None:
        data = np.asarray(row, dtype="<f8").tobytes()
        self._exports["memory"].write(self._store, data, self.call("row"))

    def row(self) -> np.ndarray:
        return self.read(self.call("row"), len(self.fields))

    def refused(self, row: Sequence[float]) -> str:
        """Return the field for which a row is refused, or nothing."""
        self.write_row(row)
        field = self.call("start")
        return self.fields[field - 1] if field else ""

    def run(self, row: Sequence[float]) -> dict[str, float]:
        assert not self.refused(row)
        while self.call("advance", math.inf):
            pass
        return dict(zip(self.results, self.read(self.call("result"), len(self.results)), strict=True))

    def numbers(self, what: str, *arguments: float) -> np.ndarray:
        count = self.call(what, *arguments)
        return self.read(self.call("numbers"), count)

    def _text(self, place: int) -> str:
        data = self._exports["memory"].read(self._store, place, place + 4096)
        return data[: data.index(b"\0")].decode()
