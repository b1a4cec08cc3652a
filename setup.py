"""The part of the build that pyproject.toml cannot say: the core in C."""

from compiler import FREE_THREADED, BuildCore, core  # of building/, on the path of the backend
from setuptools import setup

setup(
    ext_modules=[core()],
    cmdclass={"build_ext": BuildCore},
    options={} if FREE_THREADED else {"bdist_wheel": {"py_limited_api": "cp311"}},
)
