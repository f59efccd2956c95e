"""Compile the engine to WebAssembly and put it, the script and the style into one HTML file.

``make explorer`` calls it. What depends on the installed package, that is defaults, limits and
lines, is left open in the file as ``{{facts}}`` and ``{{own}}``: `pinchoff explore` fills it in.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

FLAGS = (
    *("-target", "wasm32-wasi", "-mexec-model=reactor", "-Wl,--no-entry", "-s"),
    *("-std=c++20", "-O3", "-msimd128", "-fno-exceptions", "-fno-rtti"),
    # As CMakeLists.txt: no flag lets the compiler assume that numbers are finite.
    *("-fno-math-errno", "-fno-trapping-math", "-Wall", "-Wextra", "-Wno-pass-failed"),
    *("-Iinclude", "-Isrc/core"),
)
SOURCES = ("src/explorer/engine.cpp", "src/core/kernels.cpp")

_IMPORT = re.compile(r'^import\s*\{[^}]*\}\s*from\s*"\./([\w.-]+)";\n', re.M | re.S)
_OTHER_NAME = re.compile(r"^(?:import|export)\b.*\bas\b", re.M)
_TOP_LEVEL = re.compile(r"^(?:async\s+)?(?:const|let|class|function\*?)\s+(\w+)", re.M)


def engine(build: Path) -> bytes:
    """Compile the engine."""
    build.mkdir(parents=True, exist_ok=True)
    out = build / "engine.wasm"
    caches = {name: str(build / "zig") for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")}
    command = [sys.executable, "-m", "ziglang", "c++", *FLAGS, *SOURCES, "-o", str(out)]
    subprocess.run(command, check=True, cwd=ROOT, env={**os.environ, **caches})
    return out.read_bytes()


def bundle(entry: str) -> str:
    """Join a module and all that it imports into one, each after those that it needs.

    Modules import by name and export by name, and no two have a name in common at their top
    level: then the joined text means what the modules meant.
    """
    parts: dict[str, str] = {}

    def add(name: str) -> None:
        if name in parts:
            return
        text = (HERE / name).read_text(encoding="utf-8")
        if _OTHER_NAME.search(text):
            raise SystemExit(f"{name} must import and export under the same name")
        for imported in _IMPORT.findall(text):
            add(imported)
        parts[name] = re.sub(r"^export\s+", "", _IMPORT.sub("", text), flags=re.M)

    add(entry)
    seen: dict[str, str] = {}
    for name, text in parts.items():
        for word in _TOP_LEVEL.findall(text):
            if word in seen:
                raise SystemExit(f"{name} must not define {word}: {seen[word]} does")
            seen[word] = name
    return "\n".join(parts.values())


def source_hash(text: str) -> str:
    """Return how a policy names an inline script or style."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def page(code: bytes) -> str:
    """Return the page, with the places for the facts and the user's data left open."""
    script, worker = bundle("main.js"), bundle("worker.js")
    style = (HERE / "page.css").read_text(encoding="utf-8")
    if "</script" in script + worker:
        raise SystemExit("a script must not hold the text that ends it")
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src {source_hash(script)} 'wasm-unsafe-eval'",
            f"style-src {source_hash(style)}",
            "worker-src blob:",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    filled = {
        "policy": policy,
        "style": style,
        "engine": base64.b64encode(gzip.compress(code, mtime=0)).decode(),
        "worker": worker,
        "script": script,
    }
    html = (HERE / "page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda m: filled.get(m[1], m[0]), html)


if __name__ == "__main__":
    target = Path(sys.argv[1])
    unfinished = target.with_suffix(".part")
    unfinished.write_text(page(engine(ROOT / "build" / "explorer")), encoding="utf-8")
    unfinished.replace(target)
