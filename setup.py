"""Make the README's links absolute, so that a package index follows them and shows the pictures."""

import re
import tomllib
from pathlib import Path

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
)
