"""The laboratory's compiled part, which the core contains if it was built with MOTES_LAB.

This module becomes `_core.lab`. Its stub tells type checkers what is in it; `.ci/stubs` writes it.
"""

import sys

from motes import MotesError, _core

if not hasattr(_core, "lab"):
    raise MotesError(
        "this build of motes has no laboratory: build it with -DMOTES_LAB=ON, as `pip install` does"
    )
sys.modules[__name__] = _core.lab
