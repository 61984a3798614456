"""Real-time cloth: the solver of Meyer, Debunne, Desbrun and Barr 2000, and what lies beyond it. Knows no ROS."""

from cloth_core.config import SolverConfig
from cloth_core.errors import ClothError, InputError, MeshError, MeshWarning, SettingError
from cloth_core.fluids import Fluid
from cloth_core.inputs import Grasp, Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.pose import Pose
from cloth_core.report import Slip, StepReport
from cloth_core.solver import ClothSolver
from cloth_core.state import Grip, State

__all__ = [
    "ClothError",
    "ClothMesh",
    "ClothSolver",
    "Fluid",
    "Grasp",
    "Grip",
    "InputError",
    "Inputs",
    "Material",
    "MeshError",
    "MeshWarning",
    "Pose",
    "SettingError",
    "Slip",
    "SolverConfig",
    "State",
    "StepReport",
    "Wind",
]
