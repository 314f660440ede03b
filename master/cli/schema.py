"""`dockloop schema`: JSON Schemas of systems, cases and campaigns, for editors."""

from __future__ import annotations

import click

from .common import answers_errors, print_json


@click.command()
@click.argument("kind", type=click.Choice(["system", "case", "campaign", "report"]), default="system")
@answers_errors
def schema(kind: str) -> None:
    """Print the JSON Schema of a system, a case, a campaign, or the report of a diagnosis (report.json)."""
    from master.campaign.campaign import Campaign
    from master.diagnosis.case.case import Case
    from master.system.config import Config
    from master.text.schema import json_schema

    if kind == "system":
        print_json(json_schema(Config, "A system for dockloop"))
    elif kind == "campaign":
        print_json(json_schema(Campaign, "A campaign for dockloop sweep"))
    elif kind == "report":
        from master.diagnosis.answer.report.schema import report_schema

        print_json(report_schema())
    else:
        print_json(json_schema(Case, "A case for dockloop diagnose"))
