"""The campaign's report: one HTML file with everything in it, to be sent and kept."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt

from seater_common.geometry import Dock
from seater_eval.campaign.report.figures import distributions, influence_bars, paths
from seater_eval.report.bars import Bar

Row = Mapping[str, Any]

_STYLE = """body{font:15px/1.45 sans-serif;max-width:1250px;margin:24px auto;padding:0 16px;color:#222}
table{border-collapse:collapse;margin:8px 0}td,th{padding:2px 12px 2px 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid #888}img{max-width:100%}.no{color:#c03030;font-weight:bold}
code,pre{background:#f3f3f3;padding:1px 4px;white-space:pre-wrap}details{margin:6px 0}summary{cursor:pointer}"""


def embedded(fig: Any, kind: str = "svg") -> str:
    """The figure as an image inside the page; closes it. `kind`: png where there are too many lines for svg."""
    data = io.BytesIO()
    fig.savefig(data, format=kind, **({"metadata": {"Date": None}} if kind == "svg" else {}))
    plt.close(fig)
    mime = {"svg": "image/svg+xml", "png": "image/png"}[kind]
    return f'<img alt="" src="data:{mime};base64,{base64.b64encode(data.getvalue()).decode()}">'


def write_page(
    path: Path,
    data: Mapping[str, Any],
    bars: Sequence[Bar],
    dock: Dock,
    worst_runs: Sequence[tuple[Row, str]],
) -> Path:
    """`data`: what the JSON file holds; `worst_runs`: rows, each with its embedded figure (empty: none)."""
    summary, rows = data["summary"], data["rows"]
    influence = influence_bars(summary)
    parts = [
        f"<h1>Campaign {escape(data['name'])}</h1>",
        _head(data),
        "<h2>Bars</h2>",
        _bars(bars),
        "<h2>How the runs ended</h2>",
        _table(["runs", "result", "text"], [[r["runs"], r["result"], r["text"]] for r in summary["results"]]),
        "<h2>Distributions over the docked runs</h2><p>Line: median, dashed: 95th percentile.</p>",
        embedded(distributions(rows)),
        _spreads(summary["of_docked"]),
        "<h2>Paths</h2>",
        embedded(paths(rows, dock), "png"),
        "<h2>Share of docked runs against each parameter</h2>",
        "<p>Numbers of runs in brackets, 95 % intervals by Wilson; the clearest influences first.</p>",
        embedded(influence) if influence is not None else "<p>Nothing was varied.</p>",
        _influences(summary["influences"]),
        "<h2>Worst runs</h2>",
        *(_run(data, row, image) for row, image in worst_runs),
        "<h2>Where the time goes</h2>",
        _table(["part", "share"], [[part, f"{100 * x:.1f} %"] for part, x in summary["share_of_time"].items()]),
    ]
    body = "\n".join(parts)
    head = f'<meta charset="utf-8"><title>Campaign {escape(data["name"])}</title><style>{_STYLE}</style>'
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n')
    return path


def _head(data: Mapping[str, Any]) -> str:
    s = data["summary"]
    low, high = s["docked_interval"]
    factor = "-" if s["realtime_factor"] is None else f"{s['realtime_factor']:.2f}"
    return (
        f"<p><b>{s['docked']} of {s['runs']} docked</b> (95 % interval {100 * low:.1f} .. {100 * high:.1f} %), "
        f"{s['touched']} touched a wall. Controller told: {escape(data['told'])}. "
        f"{'' if data['images'] else 'Poses drawn, no images. '}Seed {data['seed']}. "
        f"{s['simulated_s'] / 3600:.2f} h simulated in {s['core_s'] / 3600:.2f} h of one core ({factor} times real "
        f"time, images rendered and searched).</p><p>Axes: {escape(_axes(data['axes']))}</p>"
    )


def _axes(axes: Mapping[str, Any]) -> str:
    return "; ".join(f"{axis}: {', '.join(variants)}" for axis, variants in axes.items())


def _bars(bars: Sequence[Bar]) -> str:
    rows = [
        [
            bar.name,
            "not measured" if bar.value is None else f"{bar.value:.4g} {bar.unit}",
            f"{bar.sense} {bar.limit:.4g}",
            "yes" if bar.met else "NO",
        ]
        for bar in bars
    ]
    return _table(["bar", "measured", "limit", "met"], rows)


def _spreads(of_docked: Mapping[str, Any]) -> str:
    levels = ("median", "p95", "p99", "max")
    rows = [
        [name, *("-" if values[level] is None else f"{values[level]:.3g}" for level in levels)]
        for name, values in of_docked.items()
    ]
    return _table(["", *levels], rows)


def _influences(influences: Sequence[Mapping[str, Any]]) -> str:
    rows = []
    for influence in influences:
        for i, group in enumerate(influence["groups"]):
            low, high = group["interval"]
            share = f"{100 * group['docked'] / group['runs']:.1f} % ({100 * low:.1f} .. {100 * high:.1f})"
            name = "" if i else f"{influence['parameter']} ({influence['evidence']:.1f})"
            rows.append([name, group["value"], f"{group['docked']} of {group['runs']}", share])
    head = ["parameter (chi-square per degree of freedom)", "value", "docked", "share"]
    return f"<details><summary>all parameters</summary>{_table(head, rows)}</details>"


def _run(data: Mapping[str, Any], row: Row, image: str) -> str:
    numbers = ", ".join(f"{key} {value:.4g}" for key, value in row.get("numbers", {}).items())
    variants = ", ".join(f"{axis}: {variant}" for axis, variant in row.get("variants", {}).items())
    axes = f" --axes {','.join(data['axes_varied'])}" if data["axes_varied"] else ""
    told = f"--told {data['told']}" + ("" if data["images"] else " --no-images")
    command = f"--campaign {data['name']}{axes} {told} --replay seed:{row['seed']}"
    return (
        f"<h3>Case {row['index']}: {escape(str(row['result']))}</h3><pre>{escape(str(row['text']))}</pre>"
        f"<p>{escape(variants)}. {escape(numbers)}</p><p><code>docking_campaign {escape(command)}</code></p>{image}"
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    def cell(value: Any) -> str:
        text = escape(str(value))
        return f'<td class="no">{text}</td>' if text == "NO" else f"<td>{text}</td>"

    lines = ["".join(cell(value) for value in row) for row in rows]
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f"<table><tr>{top}</tr>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"
