"""`instance.variable`: the name of a signal, of a parameter or of a slot in a system."""

from __future__ import annotations

from typing import Any

from pydantic_core import core_schema


class SignalName(str):
    """
    Name of something in an FMU of a system; names of FMUs hold no dot, so the first one parts the two.

    Raises:
        ValueError: If one of the two is empty.
    """

    def __new__(cls, name: str) -> SignalName:
        """Check the name."""
        instance, _, variable = name.partition(".")
        if not (instance and variable):
            raise ValueError("not an 'instance.variable'")
        return super().__new__(cls, name)

    @classmethod
    def of(cls, instance: str, variable: str) -> SignalName:
        """Join the two."""
        return cls(f"{instance}.{variable}")

    @property
    def instance(self) -> str:
        """Name of the FMU in the system."""
        return self.partition(".")[0]

    @property
    def variable(self) -> str:
        """Name in the FMU."""
        return self.partition(".")[2]

    @property
    def parts(self) -> tuple[str, str]:
        """Return instance and variable."""
        return self.instance, self.variable

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_after_validator_function(
            cls, core_schema.str_schema(), serialization=core_schema.to_string_ser_schema()
        )
