"""Find where droplets begin to break, fit the line, and draw it beside the paper's.

Writes separating_line.png and appendix_c.png into the folder it runs in; takes seconds.
"""

import pinchoff as po
from pinchoff.figures import style
from pinchoff.figures.appendix_c import appendix_c
from pinchoff.figures.phase_diagram import separating_line
from pinchoff.studies.boundary.collapse import collapse_spread, slopes

CAPILLARY = {"simulation_capillary_number": [16, 20, 25, 32, 40, 50, 64, 80]}


def main() -> None:
    line = po.boundary(po.Parameters(size_ratio=5.66), CAPILLARY)
    print(line.table[["control_parameter", "symmetry_unbroken", "symmetry_broke", "status"]])
    print(line.fit())
    style.save("separating_line.png", separating_line(line, line.fit()))

    tensions = po.boundary(po.Parameters(), {"line_tension": [60, 190, 600, 1900], **CAPILLARY})
    print("slopes of ln S_c against ln μ̃, by γ̃:", slopes(tensions.found))
    print("agreement at equal μ̃/γ̃:", collapse_spread(tensions.found))
    style.save("appendix_c.png", appendix_c(tensions)[0])


if __name__ == "__main__":
    main()
