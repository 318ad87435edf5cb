"""Who counts as the leader, for controllers that know leaders and not people: one rule for all adapters of this folder.

A person is a leader while on the ego's lane, and while walking so as to be on it within `anticipation` seconds. A person who stands at
the kerb is none. Another vehicle is one while on the lane. The nearest of them ahead is the leader; its gap is that between the two
bodies along the lane, its speed the part along the lane, forwards.
"""

from typing import NamedTuple, Optional


class Leader(NamedTuple):
    """Whom to follow: what is free before it, m, and how fast it goes along the lane, m/s."""

    gap: float
    speed: float


def leader_of(seen, anticipation) -> Optional[Leader]:
    """The leader in what is seen, if there is one; `anticipation` in s."""
    half = seen.lane_width / 2
    people = [one for one in seen.pedestrians if _enters(one, half + one.width / 2, anticipation)]
    vehicles = [one for one in seen.vehicles if abs(one.y) < half]
    ahead = [one for one in people + vehicles if one.x > 0]
    if not ahead:
        return None
    nearest = min(ahead, key=lambda one: one.x - one.length / 2)
    gap = nearest.x - (nearest.length + seen.length) / 2
    return Leader(max(gap, 0.0), max(nearest.vx, 0.0))


def _enters(one, half, anticipation):
    """Whether somebody is within `half` metres of the lane's middle now or within that many seconds."""
    later = one.y + one.vy * anticipation
    return min(one.y, later) < half and max(one.y, later) > -half
