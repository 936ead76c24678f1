"""Sources -> bundles: what one Ray task converts, and the memory and cores to ask for.

Costs are predicted from sizes and corrected by measured times. Large files go first, so that none is left alone at the
end, and bundles shrink as the work runs out.
"""

from __future__ import annotations

import collections
import dataclasses
from typing import Deque, Iterable, List, Optional

from .sources import Source

MIB = 1 << 20

#: Seconds per file whatever its size: a fork, a check of the store, three renames.
SECONDS_PER_FILE = 0.01

#: Seconds per byte of input, before anything is measured: 2 cores of 2020, chord 1e-3.
SECONDS_PER_BYTE = 8e-8

#: Weight of a bundle's measured speed in the running mean.
LEARNING = 0.1

#: Longest bundle, seconds. A task costs Ray about 3 ms; half a second keeps that under 1 %. Longer ones save nothing
#: and delay rows, retries and the end.
LONGEST_BUNDLE, SHORTEST_BUNDLE = 4.0, 0.5

#: Most files of a bundle, whatever they are predicted to cost.
MOST_FILES = 500

#: Memory of a first attempt: of the process, and per byte of input. The largest share of 52 public files is
#: docs/batch.md's table; a file that needs more is tried again with all that one may have.
MEMORY_PER_FILE, MEMORY_PER_BYTE = 256 * MIB, 32


@dataclasses.dataclass
class Work:
    """A source and what happened to it so far."""

    source: Source
    #: Attempts that ended with a retriable outcome.
    attempts: int = 0
    #: Times that a worker was lost while at it. Not its fault in general, so counted apart.
    losses: int = 0
    #: Memory of the next attempt, bytes; `None` for what its size suggests.
    memory: Optional[int] = None
    #: Ray node of the last attempt that failed.
    node: Optional[str] = None


@dataclasses.dataclass
class Bundle:
    """What one Ray task converts."""

    works: List[Work]
    #: Bytes that each file's process may take, and that Ray is asked for.
    memory: int
    cores: int
    #: Predicted seconds.
    seconds: float

    @property
    def patience(self) -> float:
        """Seconds after which a worker starts no further file of the bundle, but gives the rest back."""
        return 2 * max(SHORTEST_BUNDLE, self.seconds)


@dataclasses.dataclass
class Limits:
    """What a file may take."""

    max_memory: int
    seconds: float
    #: Further attempts after one that failed.
    retries: int
    #: Files of at least this many bytes get several cores: one more per multiple.
    large: int
    #: Cores of the largest node.
    cores: int


class Plan:
    """The work that is left, dealt as bundles."""

    def __init__(self, sources: Iterable[Source], limits: Limits) -> None:
        self.limits = limits
        #: Measured seconds per predicted second.
        self.speed = 1.0
        by_size = sorted(sources, key=lambda source: (-(source.size or 0), source.path))
        self.waiting: Deque[Work] = collections.deque(Work(source) for source in by_size)
        #: Work that failed before, each to be tried in a bundle of its own.
        self.again: Deque[Work] = collections.deque()
        self.seconds_left = sum(predict(work.source) for work in self.waiting)

    def __bool__(self) -> bool:
        return bool(self.waiting or self.again)

    def next(self, slots: int) -> Bundle:
        """The next bundle for a cluster that runs `slots` at once. There must be work."""
        if self.again:
            return self._bundle([self.again.popleft()])
        works = [self.waiting.popleft()]
        if self.cores(works[0]) == 1:
            fair = self.seconds_left * self.speed / (2 * max(1, slots))
            room = min(LONGEST_BUNDLE, max(SHORTEST_BUNDLE, fair)) / self.speed
            seconds = predict(works[0].source)
            while self.waiting and len(works) < MOST_FILES:
                seconds += predict(self.waiting[0].source)
                if seconds > room:
                    break
                works.append(self.waiting.popleft())
        self.seconds_left -= sum(predict(work.source) for work in works)
        return self._bundle(works)

    def _bundle(self, works: List[Work]) -> Bundle:
        seconds = sum(predict(work.source) for work in works) * self.speed
        return Bundle(works, max(map(self.memory, works)), max(map(self.cores, works)), seconds)

    def give_back(self, works: List[Work]) -> None:
        """Takes files back that a worker did not do."""
        self.waiting.extendleft(reversed(works))
        self.seconds_left += sum(predict(work.source) for work in works)

    def learn(self, bundle: Bundle, done: int, seconds: float) -> None:
        """Takes the measured time of the first `done` files of a bundle into account."""
        predicted = sum(predict(work.source) for work in bundle.works[:done])
        # One bundle moves the mean by a factor of ten at most: a hanging file says nothing about others.
        ratio = min(10.0, max(0.1, seconds * bundle.cores / predicted / self.speed)) * self.speed
        self.speed += LEARNING * (ratio - self.speed)

    def memory(self, work: Work) -> int:
        """Bytes to ask for. A file that may not be tried again gets all that one may have."""
        if self.limits.retries == 0:
            return self.limits.max_memory
        return min(self.limits.max_memory, work.memory or suggest_memory(work.source))

    def cores(self, work: Work) -> int:
        return max(1, min(self.limits.cores, 1 + (work.source.size or 0) // self.limits.large))

    def failed(self, work: Work, status: str, memory: int, node: Optional[str]) -> bool:
        """Counts a failed attempt. True if the work is to be tried again, and puts it back then."""
        work.attempts += 1
        work.node = node
        if status == "limit":
            # More memory is another question, so it is no retry.
            if memory >= self.limits.max_memory:
                return False
            work.memory = self.limits.max_memory
        elif status not in RETRIED or work.attempts > self.limits.retries:
            return False
        self.again.append(work)
        return True

    def lost(self, bundle: Bundle, at: Optional[int]) -> List[Work]:
        """Puts back the files of a bundle whose worker was lost while it was at one of them, or between files. That one
        counts a loss. Returns it, and does not put it back, if it was lost too often."""
        if at is None:
            suspects, others = [], bundle.works
        else:
            suspects, others = bundle.works[at : at + 1], bundle.works[:at] + bundle.works[at + 1 :]
        for work in suspects:
            work.losses += 1
        gone = [work for work in suspects if work.losses > MOST_LOSSES]
        self.again.extend(work for work in suspects if work.losses <= MOST_LOSSES)
        if len(bundle.works) == 1:
            self.again.extend(others)
        else:
            # Results of those that were done are in the store.
            self.give_back(others)
        return gone


#: Outcomes that another attempt may change.
RETRIED = ("crashed", "timeout", "unreadable")

#: Times that a worker may be lost while at a file. Files have processes of their own, so that is hardly ever the file's
#: doing.
MOST_LOSSES = 5


def suggest_memory(source: Source) -> int:
    """Bytes for a first attempt: a power of two. Ray keeps workers for each amount that is asked for, so there must
    be few."""
    bytes_ = MEMORY_PER_FILE + MEMORY_PER_BYTE * (source.size or 0)
    return 1 << (bytes_ - 1).bit_length()


def predict(source: Source) -> float:
    """Seconds on one core, before correction by `Plan.speed`."""
    return SECONDS_PER_FILE + SECONDS_PER_BYTE * (source.size or 0)
