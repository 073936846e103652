"""Reports of a run that stay on a disk until somebody looks at one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import overload

from .journal import read_journal, record_at
from .report import StepReport


class KeptReports(Sequence[StepReport]):
    """The reports in the first ``length`` bytes of a journal: one in memory at a time."""

    def __init__(self, journal: str, length: int) -> None:
        self._journal, self._length = journal, length
        #: Where the record of each begins.
        self._places: list[int] = []
        begin = 0
        for record in read_journal(journal, length):
            if record.kind == "frame" and record.fields["report"] is not None:
                self._places.append(begin)
            begin = record.end

    def __len__(self) -> int:
        return len(self._places)

    def __iter__(self) -> Iterator[StepReport]:
        for record in read_journal(self._journal, self._length):
            if record.kind == "frame" and record.fields["report"] is not None:
                yield record.fields["report"]

    @overload
    def __getitem__(self, index: int) -> StepReport: ...

    @overload
    def __getitem__(self, index: slice) -> list[StepReport]: ...

    def __getitem__(self, index: int | slice) -> StepReport | list[StepReport]:
        if isinstance(index, slice):
            return [self._at(place) for place in self._places[index]]
        return self._at(self._places[index])

    def _at(self, place: int) -> StepReport:
        report: StepReport = record_at(self._journal, place).fields["report"]
        return report
