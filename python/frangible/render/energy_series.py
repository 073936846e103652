"""Energy and momentum of a run as series over its frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from ..errors import CacheError, one_sentence
from ..recording import Float64, Recording


@dataclass(frozen=True, slots=True, eq=False)
class EnergySeries:
    """Of all dynamic bodies, with a row for each of n steps: the state at its end."""

    #: (n,) [s].
    times: Float64
    #: (n,) [J].
    kinetic: Float64
    #: (n,) relative to its lowest value [J].
    potential: Float64
    #: (n,) what there was before the first step, and the work and the bodies that have entered
    #: since [J]; the zero is that of ``total``.
    available: Float64
    #: (n,) dissipated energy that the ledger's banks hold, to be spent again [J].
    bank: Float64
    #: For each cause (n,) what it has changed the total by since the first step began [J].
    causes: dict[str, Float64]
    #: (n, 3) world frame [N s].
    linear: Float64
    #: (n, 3) about the world's origin [N m s].
    angular: Float64
    #: (n,) linear momentum that nothing explains, relative to all momenta.
    linear_error: Float64
    #: (n,) the same of angular momentum.
    angular_error: Float64
    #: (k,) when something broke [s].
    breaks: Float64

    @property
    def total(self) -> Float64:
        """(n,) kinetic and potential energy [J]."""
        return self.kinetic + self.potential


def read_energy_series(recording: Recording) -> EnergySeries:
    """Energy and momentum in a recording's reports; `CacheError` if it has none."""
    reports = recording.reports
    if not reports:
        raise CacheError(
            f"the recording of {recording.shot!r} has no frames, so there is nothing to plot"
        )
    with one_sentence(f"the recording of {recording.shot!r}", "energy report", CacheError):
        return _series(recording)


def _series(recording: Recording) -> EnergySeries:
    reports = recording.reports
    energies, momenta = (
        [report["energy"] for report in reports],
        [report["momentum"] for report in reports],
    )
    kinetic, potential, work, banked, gain = (
        np.array([energy[key] for energy in energies])
        for key in ("kinetic", "potential", "work", "banked", "gain")
    )
    started = np.array([energy.get("started", 0.0) for energy in energies])
    # Energy that enters comes first.
    causes = sorted(energies[0]["causes"], key=lambda cause: cause != "work")
    changes = {
        cause: np.array([cast(dict[str, float], energy["causes"])[cause] for energy in energies])
        for cause in causes
    }

    # Before the first step there was the total less all changes since.
    total = kinetic + potential
    if started.any():
        changes = {"started": started, **changes}
    start = total[0] - (gain - banked + work + started)[0]
    # Bodies that were taken out of the world took energy along, which the reports do not count as a
    # change.
    if any(report["quarantined"] for report in reports):
        changes["taken out"] = np.diff(total, prepend=start) - np.sum(
            list(changes.values()), axis=0
        )
    lowest = potential.min()
    return EnergySeries(
        times=np.array([report["time"] for report in reports]),
        kinetic=kinetic,
        potential=potential - lowest,
        available=start - lowest + np.cumsum(work + started),
        bank=np.cumsum(banked),
        causes={cause: np.cumsum(change) for cause, change in changes.items()},
        linear=np.array([momentum["linear"] for momentum in momenta]),
        angular=np.array([momentum["angular"] for momentum in momenta]),
        linear_error=np.array([momentum["linear_error"] for momentum in momenta]),
        angular_error=np.array([momentum["angular_error"] for momentum in momenta]),
        breaks=np.array([report["time"] for report in reports if report["fractures"]]),
    )
