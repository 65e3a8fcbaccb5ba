# SPDX-License-Identifier: MPL-2.0
"""The build backend of pyproject.toml: scikit-build-core, with an explanation if it is not installed."""
try:
    from scikit_build_core.build import *  # noqa: F403
except ImportError as error:
    raise ImportError("`pip install` of Batten needs scikit-build-core, Debian package python3-scikit-build-core, which Debian 12 "
                      "does not have. On Debian 12, install the Debian packages that scripts/package makes (python3-batten).") from error
