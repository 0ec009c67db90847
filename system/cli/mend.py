"""The line that a user types to mend what is missing, for the Python, the install and the system at hand."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import circuits
from circuits.catalogue import later
from circuits.errors import ParameterError
from system.cli.option_names import option_of

# slow to import, and every command waits for this module
metadata, request = later("importlib.metadata"), later("urllib.request")

_AGAIN = re.compile(r"(; run noctule (characterise|calibrate) [a-z0-9-]+)((?: [a-z]+=\S+)*)")
# Who installs ngspice's library, in the order in which they are looked for.
_NGSPICE_FROM = {
    "apt-get": "apt-get install libngspice0",
    "dnf": "dnf install libngspice",
    "brew": "brew install libngspice",
}


def checkout() -> Path | None:
    """Return the folder of the sources that are run; None where noctule is installed from a wheel."""
    try:
        told = json.loads(metadata.distribution("noctule").read_text("direct_url.json") or "{}")
    except metadata.PackageNotFoundError:
        return Path(circuits.__path__[0]).resolve().parent
    if not told.get("dir_info", {}).get("editable"):
        return None
    return Path(request.url2pathname(request.urlsplit(told["url"]).path))


def require_checkout(path: Path) -> None:
    """Raise `ParameterError` for a file of a package's folder where the package is an installed one."""
    if not (path.parents[2] / "pyproject.toml").is_file():
        where = f"{path.parents[2]} is an installed package"
        raise ParameterError(f"--update-package: {where}, must be a checkout; leave it out")


def measured_again(refusal: str) -> str:
    """Return the refusal of a stale record, or of stale codes, with the options of the command that mends it.

    One of the package's own asks for one more. In an installed package the record goes to the user's caches,
    as it does where one is there already, and a record of another process does so anywhere; codes go there
    where they are found anew.
    """
    found = _AGAIN.search(refusal)
    if found is None:
        return refusal
    fields = [field.partition("=") for field in found[3].split()]
    words = [found[1], *(f"{option_of(name)} {value}" for name, _, value in fields)]
    shipped = found.end() == len(refusal) and not any(name == "process" for name, _, _ in fields)
    if shipped and checkout() is not None:
        words.append("--update-package")
    elif found[2] == "calibrate":
        words.append("--anew")
    return refusal[: found.start()] + " ".join(words) + refusal[found.end() :]


def install(*wanted: str) -> str:
    """Return the line that installs something for the Python that runs this."""
    python = shlex.quote(sys.executable)
    words = [python, "-m", "pip", "install"]
    if find_spec("pip") is None and shutil.which("uv"):
        words = ["uv", "pip", "install", "--python", python]
    return " ".join([*words, *map(shlex.quote, wanted)])


def install_extra(extra: str) -> str:
    """Return the line that installs an extra of noctule's, from where noctule itself is installed."""
    root = checkout()
    return install(f"noctule[{extra}]") if root is None else install("-e", f"{root}[{extra}]")


def install_ngspice() -> str:
    """Return the line that installs ngspice's library, or names it where nobody is known who installs it."""
    line = next((line for name, line in _NGSPICE_FROM.items() if shutil.which(name)), None)
    if line is None:
        return "export NGSPICE_LIBRARY_PATH=/path/to/libngspice.so"
    return line if os.geteuid() == 0 or line.startswith("brew") else f"sudo {line}"


def set_folder(variable: str, name: str) -> str:
    """Return the line that gives a cache a folder in which anybody may write, by its variable."""
    return f"export {variable}={Path(tempfile.gettempdir()) / f'noctule-{name}'}"
