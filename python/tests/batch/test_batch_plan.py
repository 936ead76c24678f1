"""How work is dealt."""

import pytest

from trimtess.batch import plan
from trimtess.batch.plan import MIB, Limits, Plan
from trimtess.batch.sources import Source

LIMITS = Limits(max_memory=4096 * MIB, seconds=60.0, retries=2, large=64 * MIB, cores=8)


def files(*sizes):
    return [Source(f"/{number:05}.step", size, "") for number, size in enumerate(sizes)]


def bundles(plan_: Plan, slots: int):
    found = []
    while plan_:
        found.append(plan_.next(slots))
    return found


def test_every_file_is_dealt_once_largest_first():
    sources = files(*range(0, 3_000_000, 7_000))
    dealt = [work.source for bundle in bundles(Plan(sources, LIMITS), 2) for work in bundle.works]
    assert dealt == sources[::-1]


def test_small_files_are_bundled_and_bundles_shrink_at_the_end():
    dealt = bundles(Plan(files(*[1000] * 5000), LIMITS), 2)
    assert len(dealt[0].works) > 200 and dealt[0].seconds <= plan.LONGEST_BUNDLE
    assert len(dealt[-2].works) < len(dealt[0].works) / 4
    assert sum(bundle.seconds < plan.SHORTEST_BUNDLE / 2 for bundle in dealt) <= 1


def test_a_large_file_is_alone_and_gets_cores():
    dealt = bundles(Plan(files(10, 200 * MIB, 10), LIMITS), 8)
    assert [(len(bundle.works), bundle.cores) for bundle in dealt] == [(1, 4), (2, 1)]


def test_no_file_gets_more_cores_than_a_node_has():
    assert Plan(files(4000 * MIB), LIMITS).next(8).cores == 8


def test_memory_follows_size_in_few_steps():
    amounts = [Plan(files(size), LIMITS).next(1).memory // MIB for size in (0, MIB, 10 * MIB, 30 * MIB, 900 * MIB)]
    assert amounts == [256, 512, 1024, 2048, 4096]


def test_a_file_that_cannot_be_tried_again_gets_all_memory():
    once = Limits(max_memory=4096 * MIB, seconds=60.0, retries=0, large=64 * MIB, cores=8)
    assert Plan(files(10), once).next(1).memory == 4096 * MIB


def test_bundles_follow_measured_speed():
    slow = Plan(files(*[1000] * 5000), LIMITS)
    for _ in range(60):
        bundle = slow.next(2)
        slow.learn(bundle, len(bundle.works), 10 * sum(plan.predict(work.source) for work in bundle.works))
    assert slow.speed == pytest.approx(10.0, rel=0.05)
    assert len(slow.next(2).works) <= plan.LONGEST_BUNDLE / (9 * plan.SECONDS_PER_FILE)


def test_a_hanging_file_does_not_make_every_bundle_small():
    hung = Plan(files(*[1000] * 100), LIMITS)
    bundle = hung.next(2)
    hung.learn(bundle, len(bundle.works), 600.0)
    assert hung.speed < 2.0


def test_a_crash_is_tried_again_alone_and_then_given_up():
    dealt = Plan(files(1, 2, 3), LIMITS)
    bundle = dealt.next(1)
    assert len(bundle.works) == 3
    assert dealt.failed(bundle.works[0], "crashed", bundle.memory, "n1")
    for _ in range(LIMITS.retries):
        again = dealt.next(1)
        assert [work.source for work in again.works] == [bundle.works[0].source] and again.works[0].node == "n1"
        more = dealt.failed(again.works[0], "crashed", again.memory, "n1")
    assert not more and not dealt and again.works[0].attempts == 1 + LIMITS.retries


def test_a_file_over_its_first_limit_gets_all_memory_once():
    dealt = Plan(files(1), LIMITS)
    first = dealt.next(1)
    assert dealt.failed(first.works[0], "limit", first.memory, None)
    second = dealt.next(1)
    assert second.memory == LIMITS.max_memory
    assert not dealt.failed(second.works[0], "limit", second.memory, None)


def test_files_that_a_worker_gives_back_are_dealt_again():
    dealt = Plan(files(*[1000] * 1000), LIMITS)
    before, bundle = dealt.seconds_left, dealt.next(2)
    dealt.give_back(bundle.works[3:])
    assert dealt.next(2).works[0] is bundle.works[3]
    rest = sum(len(bundle.works) for bundle in bundles(dealt, 2))
    assert rest < 1000 and dealt.seconds_left < 1e-9 < before


def test_a_file_that_workers_are_lost_at_comes_back_alone_and_is_given_up():
    dealt = Plan(files(1, 2), LIMITS)
    bundle = dealt.next(1)
    other, suspect = bundle.works
    assert dealt.lost(bundle, 1) == []
    for _ in range(plan.MOST_LOSSES - 1):
        bundle = dealt.next(1)
        assert bundle.works == [suspect] and suspect.attempts == 0
        assert dealt.lost(bundle, 0) == []
    assert dealt.lost(dealt.next(1), 0) == [suspect] and suspect.losses == 1 + plan.MOST_LOSSES
    assert dealt.next(1).works == [other] and other.losses == 0 and not dealt


def test_nobody_is_blamed_for_a_worker_that_is_lost_at_no_file():
    dealt = Plan(files(1, 2, 3), LIMITS)
    for _ in range(3 * plan.MOST_LOSSES):
        bundle = dealt.next(1)
        assert [work.source.size for work in bundle.works] == [3, 2, 1]
        assert dealt.lost(bundle, None) == []
    dealt.failed(dealt.next(1).works[2], "crashed", MIB, None)
    for _ in range(3 * plan.MOST_LOSSES):
        bundle = dealt.next(1)
        assert [(work.source.size, work.losses, work.attempts) for work in bundle.works] == [(1, 0, 1)]
        assert dealt.lost(bundle, None) == []
