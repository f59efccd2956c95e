"""The public names and the file each comes from; `__init__.py` loads them on first use."""

from .design import Chamber as Chamber
from .flow_check import FlowCheck as FlowCheck
from .flow_check import check_flow as check_flow
from .masks import write_dxf as write_dxf
from .masks import write_gds as write_gds
from .masks import write_oasis as write_oasis
from .obstacle_flow import compare_with_stokes as compare_with_stokes
from .obstacle_flow import flow_around as flow_around
from .periodic_flow import ArrayFlow as ArrayFlow
from .periodic_flow import array_flow as array_flow
from .periodic_flow import imaging_array as imaging_array
from .positions import in_frame as in_frame
from .record import read_design as read_design
from .rules import Violation as Violation
from .rules import check_rules as check_rules
from .solids import write_scad as write_scad
from .solids import write_stl as write_stl
