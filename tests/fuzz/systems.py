"""
Random valid systems: descriptions of every form, wires, orders and start values, from a seed.

FMI 3.0 enumerations pass through Int64 functions; the mixer knows a variable by its kind and reference, so a
variable of kind Int64 takes them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random
from xml.sax.saxutils import quoteattr

H = 0.01
N_STEPS = 12

FLOATS = {"2.0": ("Real",), "3.0": ("Float64", "Float64", "Float32")}
KINDS = {
    "2.0": ("Real", "Real", "Real", "Integer", "Boolean", "Enumeration"),
    "3.0": (
        "Float64", "Float64", "Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32",
        "Int64", "UInt64", "Boolean", "Enumeration",
    ),
}  # fmt: skip
CHARACTERS = [*"abZ_07 .[]()'\"<&#${%éπ度/\\-+,;:=|~^?!"]

# unit: (quantity, factor, offset) to the SI unit
UNITS = {
    "m": ("length", 1.0, 0.0),
    "mm": ("length", 1e-3, 0.0),
    "km": ("length", 1e3, 0.0),
    "K": ("temperature", 1.0, 0.0),
    "degC": ("temperature", 1.0, 273.15),
    "degF": ("temperature", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0),
    "": ("", 1.0, 0.0),
}
BASE = {"length": 'm="1"', "temperature": 'K="1"'}


@dataclass(frozen=True)
class Variable:
    """One value reference with its names: the first is the variable, the others are aliases."""

    names: tuple[str, ...]
    kind: str
    reference: int
    role: str
    shape: tuple[int, ...]
    weight: float
    unit: str
    typed: bool
    start: tuple[float, ...]

    @property
    def n(self) -> int:
        n = 1
        for size in self.shape:
            n *= size
        return n


@dataclass(frozen=True)
class Fmu:
    """One slave."""

    name: str
    version: str
    variables: tuple[Variable, ...]

    def having(self, role: str) -> list[Variable]:
        return [v for v in self.variables if v.role == role]


@dataclass(frozen=True)
class Wire:
    """A connection, by FMU, variable and the names that the file uses; whole arrays or scalars."""

    source: Fmu
    output: Variable
    source_name: str
    target: Fmu
    input: Variable
    target_name: str
    delay: int


@dataclass(frozen=True)
class RandomSystem:
    """FMUs, wires, groups that step side by side one group after the other, and values of the user's."""

    seed: int
    fmus: tuple[Fmu, ...]
    wires: tuple[Wire, ...]
    order: tuple[tuple[str, ...], ...]
    given: dict[str, dict[str, tuple[float, ...]]] = field(default_factory=dict)


def random_system(seed: int) -> RandomSystem:
    """Make the system of a seed."""
    rng = Random(seed)
    fmus = tuple(_fmu(rng, f"{'abcdef'[i]}{rng.choice(['', '_1', 'x'])}") for i in range(rng.randint(1, 4)))
    wires = tuple(_wires(rng, fmus))
    names = [f.name for f in fmus]
    rng.shuffle(names)
    order: list[tuple[str, ...]] = []
    while names:
        n = rng.choice([1, 1, 1, 2, 3])
        order.append(tuple(names[:n]))
        names = names[n:]
    wired = {(w.target.name, w.input.reference, w.input.kind) for w in wires}
    given = {f.name: _given(rng, f, wired) for f in fmus}
    return RandomSystem(seed, fmus, wires, tuple(order), given)


def _fmu(rng: Random, name: str) -> Fmu:
    version = rng.choice(["2.0", "3.0"])
    used: set[str] = set()
    references = iter(rng.sample(range(1, 500), 40))
    variables = []
    for role in [*["i"] * rng.randint(1, 6), *["o"] * rng.randint(1, 7), *["p"] * rng.randint(0, 3)]:
        variables.append(_variable(rng, version, role, next(references), used))
    rng.shuffle(variables)
    return Fmu(name, version, tuple(variables))


def _variable(rng: Random, version: str, role: str, reference: int, used: set[str]) -> Variable:
    kind = rng.choice(KINDS[version])
    is_array = version == "3.0" and rng.random() < 0.25 and kind != "Enumeration"
    shape = tuple(rng.choice([(2,), (3,), (2, 3), (1,)])) if is_array else ()
    n_names = 1 + (rng.choice([0, 0, 0, 1, 2]) if role != "p" else 0)
    names = tuple(_name(rng, used) for _ in range(n_names))
    unit = rng.choice(list(UNITS)) if kind in ("Real", "Float64", "Float32") else ""
    n = 1
    for size in shape:
        n *= size
    start = tuple(0.0 if role == "o" else _start(rng, kind) for _ in range(n))
    typed = unit != "" and rng.random() < 0.5
    weight = rng.choice([0.5, -0.25, 1.0, 0.125])
    if role == "i" and kind in ("Real", "Float64", "Float32"):
        weight *= (
            0.1 * UNITS[unit][1]
        )  # so weak, in SI units, that no loop amplifies the rounding of conversions
    return Variable(names, kind, reference, role, shape, weight, unit, typed, start)


def _name(rng: Random, used: set[str]) -> str:
    while True:
        name = "".join(rng.choice(CHARACTERS) for _ in range(rng.randint(1, 8))).strip()
        if name and name not in used and not name.endswith("]") and name[0] not in ".[":
            used.add(name)
            return name


def _start(rng: Random, kind: str) -> float:
    if kind in ("Real", "Float64"):
        return rng.uniform(-2.0, 2.0)
    if kind == "Float32":
        return rng.randint(-16, 16) / 8.0
    if kind == "Boolean":
        return float(rng.random() < 0.5)
    if kind == "Enumeration":
        return float(rng.randint(1, 4))
    return float(rng.randint(0 if kind[0] == "U" else -100, 100))


def _wires(rng: Random, fmus: tuple[Fmu, ...]) -> list[Wire]:
    outputs = [(f, v) for f in fmus for v in f.having("o")]
    wires = []
    for target in fmus:
        for v in target.having("i"):
            fitting = [(f, o) for f, o in outputs if _fits(o, v)]
            if fitting and rng.random() < 0.8:
                source, output = rng.choice(fitting)
                names = rng.choice(output.names), rng.choice(v.names)
                wires.append(
                    Wire(source, output, names[0], target, v, names[1], rng.choice([0, 0, 0, 1, 2, 3]))
                )
    return wires


def _fits(output: Variable, v: Variable) -> bool:
    quantities = UNITS[output.unit][0], UNITS[v.unit][0]
    alike = {"Real": "Float64", "Integer": "Int32"}
    return (
        output.shape == v.shape
        and quantities[0] == quantities[1]
        and alike.get(output.kind, output.kind) == alike.get(v.kind, v.kind)
    )


def _given(rng: Random, fmu: Fmu, wired: set[tuple[str, int, str]]) -> dict[str, tuple[float, ...]]:
    """Values that the user gives to parameters and free inputs, by any of the names."""
    values = {}
    for v in fmu.variables:
        is_free = v.role == "p" or (v.role == "i" and (fmu.name, v.reference, v.kind) not in wired)
        if is_free and rng.random() < 0.5:
            values[rng.choice(v.names)] = tuple(_start(rng, v.kind) for _ in range(v.n))
    return values


def layout(fmu: Fmu) -> str:
    """Lines that the mixer reads."""
    kinds = {"Enumeration": "Int64"} if fmu.version == "3.0" else {}
    lines = []
    for v in fmu.variables:
        start = " ".join(map(repr, v.start))
        lines.append(f"{kinds.get(v.kind, v.kind)} {v.reference} {v.n} {v.role} {v.weight!r} {start}\n")
    return "".join(lines)


def text(kind: str, value: float) -> str:
    """Value as FMI writes it."""
    if kind == "Boolean":
        return "true" if value else "false"
    return repr(value) if kind in ("Real", "Float64", "Float32") else str(int(value))


CAUSALITY = {
    "i": 'causality="input"',
    "o": 'causality="output"',
    "p": 'causality="parameter" variability="fixed"',
}


def describe(fmu: Fmu) -> str:
    """modelDescription.xml of a slave."""
    return _describe_2(fmu) if fmu.version == "2.0" else _describe_3(fmu)


def _units(fmu: Fmu) -> str:
    used = sorted({v.unit for v in fmu.variables} - {""})
    units = []
    for unit in used:
        quantity, factor, offset = UNITS[unit]
        base = f'<BaseUnit {BASE[quantity]} factor="{factor!r}" offset="{offset!r}"/>'
        units.append(f'<Unit name="{unit}">{base}</Unit>')
    return f"<UnitDefinitions>{''.join(units)}</UnitDefinitions>" if units else ""


def _types(fmu: Fmu) -> list[str]:
    return sorted({v.unit for v in fmu.variables if v.typed})


def _describe_2(fmu: Fmu) -> str:
    types = "".join(f'<SimpleType name="in_{u}"><Real unit="{u}"/></SimpleType>' for u in _types(fmu))
    items = "".join(f'<Item name="item{i}" value="{i}"/>' for i in range(1, 5))
    types += f'<SimpleType name="Choice"><Enumeration>{items}</Enumeration></SimpleType>'
    variables = []
    for v in fmu.variables:
        varies = "" if v.role == "p" else "" if v.kind == "Real" else ' variability="discrete"'
        start = f' start="{text(v.kind, v.start[0])}"' if v.role != "o" else ""
        more = ' declaredType="Choice"' if v.kind == "Enumeration" else _unit(v)
        for name in v.names:
            variables.append(
                f'<ScalarVariable name={quoteattr(name)} valueReference="{v.reference}" {CAUSALITY[v.role]}'
                f"{varies}><{v.kind}{more}{start}/></ScalarVariable>"
            )
    outputs = [i + 1 for i, text_ in enumerate(variables) if 'causality="output"' in text_]
    structure = "".join(f'<Unknown index="{i}"/>' for i in outputs)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiModelDescription fmiVersion="2.0" modelName="mixer" guid="mixer">\n'
        '<CoSimulation modelIdentifier="mixer" canHandleVariableCommunicationStepSize="true"/>\n'
        f"{_units(fmu)}<TypeDefinitions>{types}</TypeDefinitions>\n"
        f"<ModelVariables>{''.join(variables)}</ModelVariables>\n"
        f"<ModelStructure><Outputs>{structure}</Outputs></ModelStructure>\n</fmiModelDescription>\n"
    )


def _unit(v: Variable) -> str:
    if v.unit == "":
        return ""
    return f' declaredType="in_{v.unit}"' if v.typed else f' unit="{v.unit}"'


def _describe_3(fmu: Fmu) -> str:
    types = "".join(
        f'<{k}Type name="in_{u}_{k}" unit="{u}"/>' for u in _types(fmu) for k in ("Float64", "Float32")
    )
    items = "".join(f'<Item name="item{i}" value="{i}"/>' for i in range(1, 5))
    types += f'<EnumerationType name="Choice">{items}</EnumerationType>'
    variables = []
    for v in fmu.variables:
        is_float = v.kind in ("Float64", "Float32")
        varies = "" if v.role == "p" or is_float else ' variability="discrete"'
        start = f' start="{" ".join(text(v.kind, x) for x in v.start)}"' if v.role != "o" else ""
        more = ' declaredType="Choice"' if v.kind == "Enumeration" else _unit(v)
        if v.typed:
            more = f' declaredType="in_{v.unit}_{v.kind}"'
        inside = "".join(f'<Dimension start="{n}"/>' for n in v.shape)
        inside += "".join(f"<Alias name={quoteattr(name)}/>" for name in v.names[1:])
        variables.append(
            f'<{v.kind} name={quoteattr(v.names[0])} valueReference="{v.reference}" {CAUSALITY[v.role]}'
            f"{varies}{more}{start}>{inside}</{v.kind}>"
        )
    outputs = "".join(f'<Output valueReference="{v.reference}"/>' for v in fmu.having("o"))
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiModelDescription fmiVersion="3.0" modelName="mixer" instantiationToken="mixer">\n'
        '<CoSimulation modelIdentifier="mixer" canHandleVariableCommunicationStepSize="true"/>\n'
        f"{_units(fmu)}<TypeDefinitions>{types}</TypeDefinitions>\n<ModelVariables>"
        '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
        f"{''.join(variables)}</ModelVariables>\n<ModelStructure>{outputs}</ModelStructure>\n</fmiModelDescription>\n"
    )
