"""JSON Schema of `report.json`, which `dockloop diagnose --json` prints."""

from __future__ import annotations

from typing import Any

from master.diagnosis.answer.claims import Status, Verdict
from master.text.schema import DIALECT

Schema = dict[str, Any]

NUMBER: Schema = {"type": "number"}
TEXT: Schema = {"type": "string"}
TRUTH: Schema = {"type": "boolean"}
COUNT: Schema = {"type": "integer", "minimum": 0}
SHARE_INTERVAL: Schema = {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _list(schema: Schema) -> Schema:
    return {"type": "array", "items": schema}


def _by_name(schema: Schema) -> Schema:
    """An object whose keys are names of signals, parameters or parts."""
    return {"type": "object", "additionalProperties": schema}


def _object(description: str = "", **properties: Schema) -> Schema:
    """An object with these keys and no others, all of them always there."""
    told = {"description": description} if description else {}
    return {**_of_keys(properties), **told}


def _of_keys(properties: dict[str, Schema]) -> Schema:
    """The same, with keys that Python does not take as names."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def report_schema() -> Schema:
    """Return the schema; values are in the units of the signals and parameters that they are of."""
    error = _object(
        "Errors on the sealed rows; null where a prediction is not finite.",
        rmse=_or_null(NUMBER),
        nrmse_percent=_or_null(NUMBER),
        max=_or_null(NUMBER),
        energy=_or_null(NUMBER),
        rmse_interval=_or_null(SHARE_INTERVAL),
    )
    effect = _object(
        "An effect that was added, with what it takes of the sealed power that the others leave.",
        fmu=TEXT,
        slot=TEXT,
        effect=TEXT,
        parameters=_by_name(_or_null(NUMBER)),
        no_number=_by_name(TEXT),
        status={"enum": [status.value for status in Status]},
        why=TEXT,
        sealed_gain=_or_null(NUMBER),
        sealed_gain_interval=_or_null(SHARE_INTERVAL),
        left_over_floor=NUMBER,
    )
    predictor = _object(what=TEXT, share=NUMBER, interval=SHARE_INTERVAL)
    stage = _object(
        model=TEXT,
        rms=NUMBER,
        over_floor=NUMBER,
        predictable_share=NUMBER,
        interval=SHARE_INTERVAL,
        predictors=_list(predictor),
    )
    fitted = _object(
        nominal=_or_null(NUMBER),
        refitted=_or_null(NUMBER),
        deviation_refitted=_or_null(NUMBER),
        with_effect=_or_null(NUMBER),
        deviation=_or_null(NUMBER),
        at_bound=TRUTH,
        no_number=TEXT,
    )
    channel: Schema = {
        "type": "object",
        "description": "Adequacy of a compared signal; without a noise floor where the replay is exact.",
        "properties": {
            "exact": TRUTH,
            "unknown": TEXT,
            "noise_floor": NUMBER,
            "evidence": TEXT,
            "noise_of_inputs": NUMBER,
            "adequate": TRUTH,
            "colour": TEXT,
            "events": _list(NUMBER),
            "strikes": _list(NUMBER),
            "faults": _list(_object(kind=TEXT, value=NUMBER, deviation=NUMBER, text=TEXT)),
            "stages": _list(stage),
        },
        "required": ["exact", "stages"],
        "additionalProperties": False,
    }
    fault = _object(
        part=TEXT,
        channel=TEXT,
        kind=TEXT,
        where=TEXT,
        exact=TRUTH,
        rms_before=NUMBER,
        rms_after=NUMBER,
    )
    ceiling = _object(
        share=NUMBER,
        by_regressors=NUMBER,
        interval=SHARE_INTERVAL,
        error=NUMBER,
        share_after=NUMBER,
        error_after=NUMBER,
    )
    member = _object(effect=TEXT, gain=NUMBER, sealed_rmse=_by_name(_or_null(NUMBER)), cannot_be_told=TRUTH)
    runner_up = _object(
        round=COUNT, effect=TEXT, gain=NUMBER, why=TEXT, sealed_rmse=_by_name(_or_null(NUMBER))
    )
    properties: dict[str, Schema] = {
        "name": TEXT,
        "verdict": {"enum": [verdict.value for verdict in Verdict]},
        "sentence": TEXT,
        "complete": TRUTH,
        "effects": _list(effect),
        "subsystem": _or_null(TEXT),
        "faults": _list(fault),
        "before": _by_name(error),
        "after": _by_name(error),
        "nominal": _by_name(error),
        "explained_share": _or_null(NUMBER),
        "ceiling": _or_null(ceiling),
        "channels": _by_name(channel),
        "runners_up": _list(runner_up),
        "classes": _list(_of_keys({"round": COUNT, "class": TEXT, "members": _list(member)})),
        "undistinguished": _list(_object(family=_list(TEXT), experiment=TEXT)),
        "parameters": _by_name(fitted),
        "input_rows": _by_name({"enum": ["start", "end"]}),
        "changed_rows": _by_name({"enum": ["start", "end"]}),
        "recordings": _by_name(_object(rows=COUNT, period=NUMBER, notes=_list(TEXT))),
        "residual": _by_name({"type": "object"}),
        "files": _list(TEXT),
    }
    return {
        "$schema": DIALECT,
        "title": "What dockloop diagnose --json prints",
        "type": "object",
        "properties": properties,
        "required": list(properties),
    }
