"""The C files that a fused system has in common with every native FMU; they need CasADi to be there."""

from __future__ import annotations

from master.installation import require_native

_WORK = "the fused form of a system"


def wrapper_sources() -> dict[str, bytes]:
    """
    Read the C files that all models share.

    Raises:
        ConfigError: If what builds native FMUs is not installed.
    """
    require_native(_WORK)
    from fmu_sources.export.native import codegen

    return codegen.wrapper_sources()


def fmi_headers() -> dict[str, bytes]:
    """
    Read the headers of FMI 2.0 and FMI 3.0.

    Raises:
        ConfigError: If what builds native FMUs is not installed.
    """
    require_native(_WORK)
    from fmu_sources.export.native import codegen

    return codegen.fmi_headers()
