"""Names that the writer and the reader of SSP archives share."""

from __future__ import annotations

SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSB = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
PREFIXES = {"ssc": SSC, "ssd": SSD, "ssv": SSV, "ssm": SSM, "ssb": SSB}

SUFFIXES = (".ssp", ".ssd")
STRUCTURE = "SystemStructure.ssd"
COUPLING = "org.dockloop.coupling"
COUPLING_ELEMENT = f"{{{COUPLING}}}Coupling"

FMU = "application/x-fmu-sharedlibrary"
DEFINITION = "application/x-ssp-definition"
PACKAGE = "application/x-ssp-package"
TABLES = ("text/csv", "application/table")  # the second is what OMSimulator writes
PARAMETER_SET = "application/x-ssp-parameter-set"
PARAMETER_MAPPING = "application/x-ssp-parameter-mapping"
SIGNAL_DICTIONARY = "application/x-ssp-signal-dictionary"

WHOLE_TYPES = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")


def ssc(tag: str) -> str:
    """Name of an element of the common schema."""
    return f"{{{SSC}}}{tag}"


def ssd(tag: str) -> str:
    """Name of an element of the structure schema."""
    return f"{{{SSD}}}{tag}"


def ssv(tag: str) -> str:
    """Name of an element of the parameter schema."""
    return f"{{{SSV}}}{tag}"


def ssm(tag: str) -> str:
    """Name of an element of the mapping schema."""
    return f"{{{SSM}}}{tag}"


def ssb(tag: str) -> str:
    """Name of an element of the dictionary schema."""
    return f"{{{SSB}}}{tag}"
