import re
from pathlib import Path

from setuptools import setup

header = Path(__file__).resolve().parent.parent / "linkwright.h"
version = re.search(r'LW_VERSION_STRING "(.*)"', header.read_text()).group(1)
setup(version=version, packages=["linkwright"], package_data={"linkwright": ["py.typed"]},
      cffi_modules=["build_c.py:ffibuilder"])
