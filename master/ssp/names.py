"""Names that the writer and the reader of SSP archives share."""

from __future__ import annotations

SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"

STRUCTURE = "SystemStructure.ssd"
COUPLING = "org.dockloop.coupling"


def ssc(tag: str) -> str:
    """Name of an element of the common schema."""
    return f"{{{SSC}}}{tag}"


def ssd(tag: str) -> str:
    """Name of an element of the structure schema."""
    return f"{{{SSD}}}{tag}"


def ssv(tag: str) -> str:
    """Name of an element of the parameter schema."""
    return f"{{{SSV}}}{tag}"
