"""Mechanisms: which exist, how they move, what they carry, and which one does a job.

Units are SI everywhere: lengths in m, angles in rad counter-clockwise, time in s, mass in kg, force in N.
Links, joints, tracers and inputs count from 0.  Failures raise linkwright.Error with the library's text.

    >>> import linkwright as lw
    >>> sum(1 for chain in lw.chains(8))
    16
    >>> leg = lw.Linkage.load("examples/jansen.json")
    >>> path = leg.trace(360)                    # path.x, path.y: NumPy arrays
    >>> results = lw.fit(lw.Target.load("examples/walking-foot.csv"))
    >>> results[0].linkage.save("foot.json")
"""
from ._core import Error, Stopped, version
from .catalogue import Catalogue, Hit
from .dynamics import Model, Simulation, Stepper
from .family import Family, Variant, simulate_servo
from .fitting import Result, Results, Target, fit, precision_points
from .linkage import FourBarClass, Kinematics, Linkage, Trace, classify
from .space import Frames, SpatialModel, SpatialSimulation, SpatialTrace
from .topology import Chain, Mechanism, chains, count_chains

__version__ = version()
__all__ = ["Catalogue", "Chain", "Error", "Family", "FourBarClass", "Frames", "Hit", "Kinematics", "Linkage", "Mechanism",
           "Model", "Result", "Results", "Simulation", "SpatialModel", "SpatialSimulation", "SpatialTrace", "Stepper",
           "Stopped", "Target", "Trace", "Variant", "chains", "classify", "count_chains", "fit", "precision_points",
           "simulate_servo", "version"]
