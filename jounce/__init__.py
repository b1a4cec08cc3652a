"""The packages of jounce under one name, each loaded when asked for."""

__all__ = [
    "__version__",
    "analysis",
    "app",
    "core",
    "fmu",
    "plant",
    "plots",
    "shaping",
]

TYPE_CHECKING = False  # typing's own would be an import
if TYPE_CHECKING:
    from . import analysis, app, core, fmu, plant, plots, shaping

    __version__: str


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("jounce")
        globals()[name] = value
        return value
    from importlib import import_module

    return import_module(f".{name}", __name__)


def __dir__() -> list[str]:
    return sorted(__all__)
