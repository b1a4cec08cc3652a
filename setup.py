"""What pyproject.toml cannot say: the core in C, and links that a package index can follow."""

import re
import tomllib
from pathlib import Path

from compiler import FREE_THREADED, BuildCore, core  # of building/, on the path of the backend
from setuptools import setup

ROOT = Path(__file__).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def absolute(link: re.Match[str]) -> str:
    """Return a link in Markdown that leads to the repository."""
    picture, text, target = link.groups()
    kind = "raw" if picture else "blob"
    return f"{picture}[{text}]({PROJECT['urls']['Repository']}/{kind}/HEAD/{target})"


setup(
    long_description=re.sub(r"(!?)\[([^\]]*)\]\((?!https?://|#)([^)\s]+)\)", absolute, README),
    long_description_content_type="text/markdown",
    ext_modules=[core()],
    cmdclass={"build_ext": BuildCore},
    options={} if FREE_THREADED else {"bdist_wheel": {"py_limited_api": "cp311"}},
)
