"""All parts, in the order in which they are made; the functions of each may mention those of parts before it."""
from __future__ import annotations

from .alone_lanes import TracersInLanes
from .asked import Ensemble, PlainSums, Tangent
from .axes import Axes
from .composed import Composed
from .distributed import Distributed
from .few import FewInLanes
from .held import Standing
from .lane_sphere import MembersInLanes
from .lanes import GradientsInLanes
from .pair_rows import PairsByRows
from .pairs import PairsOfSites
from .response import Responses
from .row_part import ByRows
from .site_numbers import SiteNumbers
from .solo import LoneMotion, SingleSphere
from .sublattices import Sublattices
from .thermal import Thermal
from .torque import Torques
from .visiting import VisitedInOrder
from .wide import Extended

FIRST = (Responses(), Standing(), Thermal())      # before bounds of the Hessian are found
PARTS = (*FIRST, PlainSums(), Tangent(), Torques(), ByRows(), FewInLanes(), TracersInLanes(), SingleSphere(), LoneMotion(), MembersInLanes(), Composed(), Axes(), Sublattices(), PairsOfSites(), PairsByRows(),
         Extended(), GradientsInLanes(), SiteNumbers(), VisitedInOrder(), Ensemble(), Distributed())
