"""docs/numbers.md from the results, so that no number is typed by hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pt_engine.render.schedule import WAVES
from pt_engine.render.settings import RenderSettings

from .memory import LIMITS
from .shapes import FRAMES, TITLES
from .stages import STAGES

Results = dict[str, Any]


def page(results: Results) -> str:
    """The whole page; sections that were not measured are left out."""
    parts = ["# Numbers\n\nMade by `python -m bench all`; not edited by hand."]
    parts.append(machine_text(results["machine"]))
    sections = {
        "renders": renders_text,
        "stages": stages_text,
        "memory": memory_text,
        "textures": textures_text,
    }
    for name, section in sections.items():
        if name in results:
            parts.append(section(results[name]))
    return "\n\n".join(parts) + "\n"


def table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    header = list(header)
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def textures_text(textures: Results) -> str:
    """A row an image."""
    keys = [key for key in next(iter(textures.values())) if key != "decode"]
    rows = [[n, f"{r['decode']:.2f}", *(f"{r[k]:.0f}" for k in keys)] for n, r in textures.items()]
    title = "## Textures: an image of 4096 × 4096; seconds to decode it, then nanoseconds a look-up\n\n"
    return title + table(["image", "decode, s", *keys], rows)


def machine_text(machine: Results) -> str:
    """What it was measured on."""
    versions = ", ".join(f"{k} {v}" for k, v in machine["versions"].items() if k != "platform")
    load = "" if machine["load"] is None else f", load average {machine['load']:.1f} at the start"
    return (
        f"{machine['processor']}, {machine['cores']} cores{load}. {versions}. In arrays as a pass has them, "
        f"numpy takes {machine['product_ns']:.2f} ns for a product of two float32 numbers."
    )


def millions(value: float) -> str:
    """1234567 as 1.23."""
    return f"{value / 1e6:.2f}"


def renders_text(renders: Results) -> str:
    """Paces of whole renders."""
    rows = []
    for name, r in renders.items():
        frame = FRAMES[name]
        peers = [millions(r[p]["samples_per_second"]) if p in r else "–" for p in ("mitsuba", "cycles")]
        rows.append(
            [
                f"{name}: {TITLES[name]}, {frame.width}×{frame.height}, {frame.max_depth} edges",
                millions(r["target"]),
                millions(r["independent"]["samples_per_second"]),
                millions(r["sobol"]["samples_per_second"]),
                f"{100 * r['sobol_cost']:+.0f} %",
                f"{r['two_threads_gain']:.2f} ×",
                *peers,
                millions(r["embree_only_samples_per_cpu_second"]),
                f"{100 * r['embree_share']:.0f} %",
                f"{100 * r['sobol']['cpu_per_second']:.0f} %",
            ]
        )
    header = [
        "scene",
        "target",
        "independent",
        "Sobol",
        "Sobol costs",
        "2 threads",
        "Mitsuba",
        "Cycles",
        "Embree alone",
        "time in Embree",
        "undisturbed",
    ]
    return (
        "## Whole renders\n\nMillions of camera samples per second: render phase of "
        "`python -m pt_engine render` on one core; Mitsuba `scalar_rgb` and Cycles on one core of the same "
        "run; the same rays through Embree with nothing in between. "
        "*Undisturbed*: CPU time over wall time of the run, 100 % on an idle machine.\n\n"
        + table(header, rows)
    )


def stages_text(stages: Results) -> str:
    """Nanoseconds per path vertex."""
    names = list(stages)
    rows = [
        [stage, *(f"{stages[n]['ns_per_vertex'][stage]:.1f}" for n in names)]
        for stage in STAGES
        if any(stages[n]["ns_per_vertex"][stage] > 0 for n in names)
    ]
    rows.append(["**sum**", *(f"**{stages[n]['ns_per_vertex_total']:.0f}**" for n in names)])
    rows.append(["vertices per camera sample", *(f"{stages[n]['vertices_per_sample']:.2f}" for n in names)])
    for kind in ("closest", "shadow"):
        counts = (stages[n]["rays_per_sample"][kind] for n in names)
        rows.append([f"{kind} rays per sample", *(f"{count:.2f}" for count in counts)])
    for what, key in (("keeping the ledger costs", "cost"), ("… looking into every unit", "looked_into")):
        costs = (stages[n]["ledger_costs"][key] for n in names)
        rows.append([what, *(f"{100 * mean:+.1f} ± {100 * error:.1f} %" for mean, error in costs)])
    rows.append(["M samples per CPU second", *(millions(stages[n]["samples_per_cpu_second"]) for n in names)])
    return (
        "## Stages\n\nNanoseconds of CPU time per path vertex (a hit that scatters), one core, independent "
        f"sampler, up to {WAVES} wavefronts of {RenderSettings.lanes:,} lanes a unit. "
        "`intersect` and `shadow` are Embree alone. What the ledger costs: mean and standard error of many "
        "renders of the same units, with it and without in turns.\n\n" + table(["stage", *names], rows)
    )


def memory_text(memory: Results) -> str:
    """The three slopes against their limits."""
    units = (("million triangles", 1e6, "MB"), ("pixel", 1.0, "B"), ("thread", 1e6, "MB"))
    rows = []
    for what, scale, unit in units:
        key = "per_" + what.replace("million ", "million_")
        rows.append([what, *(f"{values[key] / scale:.0f} {unit}" for values in (memory, LIMITS))])
    return (
        "## Memory\n\nBeyond what Blender itself holds, at the peak of export, build and render; of the "
        f"triangles {memory['per_million_triangles_kept'] / 1e6:.0f} MB per million stay while rendering.\n\n"
        + table(["per", "measured", "limit"], rows)
    )
